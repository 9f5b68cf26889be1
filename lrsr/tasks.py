"""What does each command do with its composed configuration? It hands plain values to one function.

Every task returns the folder that holds its result; the command line prints it last.
"""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lrsr.configuration import number, require, section, whole_number, whole_numbers
from lrsr.paths import cache_folder
from lrsr.provenance import write_provenance

if TYPE_CHECKING:
    from omegaconf import DictConfig


def run_eval(config: "DictConfig") -> Path:
    """Run a verification experiment; see :mod:`lrsr.experiments.verification`.

    Raises:
        InputError: A setting is wrong; nothing has been rendered by then.
    """
    from lrsr.experiments.run import verify  # torch takes seconds; `lrsr --help` does not need it
    from lrsr.experiments.settings import verification_settings

    settings = verification_settings(config)
    folder = _run_folder()
    write_provenance(folder, config)
    return verify(
        settings,
        folder,
        cache=_cache(config),
        camera=_instantiate(config.camera),
        model=_path(config.recognition.model),
    )


run_demo = run_eval


def run_render(config: "DictConfig") -> Path:
    """Write probes or the gallery as PNG files with a manifest; see :mod:`lrsr.data.render`.

    Raises:
        InputError: A setting is wrong.
    """
    from lrsr.data.render import RenderSettings, render_to_folder
    from lrsr.experiments.settings import IdentityRange, RenderingSettings

    out = _path(config.out)
    require(out is not None, "out", None, "a folder for the pictures, e.g. out=probes")
    settings = RenderSettings(
        out=out,
        **asdict(section(IdentityRange, config, "identities")),
        **asdict(section(RenderingSettings, config, "rendering")),
        kind=config.kind,
        pose=_instantiate(config.pose),
        lighting=_instantiate(config.lighting),
        compression=str(config.compression),
        ipd_px=number(config, "ipd_px"),
        scales=whole_numbers(config, "scales"),
        png16=bool(config.png16),
        camera=_instantiate(config.camera),
        seed=whole_number(config, "seed"),
        cache=_cache(config),
    )
    folder = render_to_folder(settings).parent
    write_provenance(folder, config)
    return folder


def _instantiate(config: "DictConfig") -> Any:
    from hydra.utils import instantiate  # loaded by then

    return instantiate(config)


def _run_folder() -> Path:
    from hydra.core.hydra_config import HydraConfig  # loaded by then

    return Path(HydraConfig.get().runtime.output_dir)


def _cache(config: "DictConfig") -> Path:
    return _path(config.paths.cache) or cache_folder()


def _path(value: object) -> Path | None:
    return None if value is None else Path(str(value)).expanduser().resolve()
