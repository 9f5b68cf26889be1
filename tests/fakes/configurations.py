"""What a command is told, without its command line: composed once for each choice of groups."""

import copy
from functools import cache

from hydra import compose, initialize_config_dir
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import DictConfig

from lrsr.paths import config_folder


def composed(command: str, *words: str) -> DictConfig:
    """Compose a command's configuration; values are set by Hydra in a copy of what groups give."""
    chosen = [word for word in words if (config_folder() / word.lstrip("+").split("=")[0]).is_dir()]
    config = copy.deepcopy(_of_groups(command, *chosen))
    values = [word for word in words if word not in chosen]
    ConfigLoaderImpl._apply_overrides_to_config(
        OverridesParser.create().parse_overrides(values), config
    )
    return config


@cache
def _of_groups(command: str, *words: str) -> DictConfig:
    with initialize_config_dir(str(config_folder()), version_base="1.3"):
        return compose(command, list(words))
