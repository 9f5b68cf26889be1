"""What does each command do with its composed configuration? A plain function call each.

Every task returns the folder that holds its result; the command line prints it last.
"""

import logging
from pathlib import Path
from typing import TYPE_CHECKING

from lrsr.paths import cache_folder
from lrsr.provenance import write_provenance

if TYPE_CHECKING:
    from omegaconf import DictConfig

logger = logging.getLogger(__name__)


def run_eval(config: "DictConfig") -> Path:
    """Run a verification experiment; see :mod:`lrsr.experiments.verification`.

    Raises:
        InputError: A setting is wrong; nothing has been rendered by then.
    """
    from lrsr.experiments.settings import verification_settings  # torch is heavy
    from lrsr.experiments.verification import verify

    settings = verification_settings(config)
    folder = _run_folder()
    write_provenance(folder, config)
    return verify(settings, folder, _cache(config), model=_path(config.recognition.model))


run_demo = run_eval


def _run_folder() -> Path:
    from hydra.core.hydra_config import HydraConfig  # loaded by then

    return Path(HydraConfig.get().runtime.output_dir)


def _cache(config: "DictConfig") -> Path:
    return _path(config.paths.cache) or cache_folder()


def _path(value: object) -> Path | None:
    return None if value is None else Path(str(value)).expanduser().resolve()
