"""What a command is told, without its command line: composed once for each choice of groups."""

import copy
from functools import cache
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import DictConfig

from lrsr.overrides import Overrides
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


_COMPOSED = Overrides._composed


def compose_keys_once(patch: pytest.MonkeyPatch) -> None:
    """Compose what a command's words are checked against once for equal groups."""

    def composed(self: Overrides, words: list[str]) -> DictConfig:
        empty = {one for one in self.folders if one.is_dir() and not any(one.iterdir())}
        folders = tuple(one for one in self.folders if one not in empty)
        return _keys(self.command, folders, tuple(words))

    patch.setattr(Overrides, "_composed", composed)


@cache
def _keys(command: str, folders: tuple[Path, ...], words: tuple[str, ...]) -> DictConfig:
    return _COMPOSED(Overrides(command, folders), list(words))
