"""What does each command do with its composed configuration? It hands plain values to one function.

Every task returns the folder that holds its result; the command line prints it last.
"""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from lrsr.configuration import number, numbers, section, whole_number, whole_numbers
from lrsr.errors import InputError
from lrsr.experiments.settings import IdentityRange, RenderingSettings, verification_settings
from lrsr.paths import cache_folder
from lrsr.provenance import write_provenance

if TYPE_CHECKING:
    from omegaconf import DictConfig

    from lrsr.identities.splits import Split


def run_eval(config: "DictConfig") -> Path:
    """Run a verification experiment; see :mod:`lrsr.experiments.verification`.

    Raises:
        InputError: A setting is wrong; nothing has been rendered by then.
    """
    from lrsr.experiments.run import verify  # torch takes seconds

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

    out = _path(config.out)
    if out is None:
        raise InputError("out=null: give the folder for the pictures, e.g. out=probes")
    people = section(IdentityRange, config, "identities")
    settings = RenderSettings(
        out=out,
        split=cast("Split", people.split),
        start=people.start,
        count=people.count,
        cast=people.cast,
        **asdict(section(RenderingSettings, config, "rendering")),
        kind=config.kind,
        pose=_instantiate(config.pose),
        lighting=_instantiate(config.lighting),
        lens=_instantiate(config.lens),
        standpoint=_instantiate(config.standpoint),
        expression=_instantiate(config.expression),
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


def run_identities(config: "DictConfig") -> Path:
    """Show a set of people and redraw look-alikes; see :mod:`lrsr.experiments.people`.

    Raises:
        InputError: A setting is wrong; nothing has been rendered by then.
    """
    from lrsr.experiments.people import check_uniqueness  # torch takes seconds
    from lrsr.experiments.uniqueness import uniqueness_settings

    settings = uniqueness_settings(config)
    folder = _run_folder()
    write_provenance(folder, config)
    return check_uniqueness(
        settings,
        folder,
        cache=_cache(config),
        camera=_instantiate(config.camera),
        model=_path(config.recognition.model),
    )


def run_fit_camera(config: "DictConfig") -> Path:
    """Estimate a camera from real pictures; see :mod:`lrsr.calibration.from_pictures`.

    Raises:
        InputError: A setting is wrong, the pictures cannot be used, or show nothing.
    """
    from omegaconf import OmegaConf

    from lrsr.calibration.from_pictures import FitSettings, fit_to_folder  # torch takes seconds
    from lrsr.data.recipe import ProbeRecipe

    people = section(IdentityRange, config, "identities")
    groups = ("pose", "lighting", "expression", "lens", "standpoint")
    scene = {group: _instantiate(config[group]) for group in groups}
    quality = asdict(section(RenderingSettings, config, "rendering"))
    preset: Any = OmegaConf.to_container(config.camera, resolve=True)
    settings = FitSettings(
        images=Path(str(config.images)).expanduser().resolve(),
        preset=preset,
        strangers=[
            ProbeRecipe(
                split=cast("Split", people.split),
                index=index,
                population=people.cast.population,
                draw=people.cast.draw(people.split, index),
                **scene,
                **quality,
            )
            for index in range(people.start, people.start + people.count)
        ],
        name=str(config.name),
        ipd_px=None if config.ipd_px is None else number(config, "ipd_px"),
        part=number(config, "part"),
        rounds=whole_number(config, "rounds"),
        seed=whole_number(config, "seed"),
    )
    folder = _run_folder()
    write_provenance(folder, config)
    return fit_to_folder(settings, folder, cache=_cache(config))


def run_train(config: "DictConfig") -> Path:
    """Train SRCNN or an embedder on probes rendered on the fly, into the run folder.

    Raises:
        InputError: Neither or both were asked for, or a setting is wrong.
    """
    asked = [key for key in ("sr", "recognition") if config.get(key) is not None]
    if len(asked) != 1:
        raise InputError("what to train? give one of sr=srcnn2x, sr=srcnn4x, recognition=arcface")
    return _train_sr(config) if asked == ["sr"] else _train_recognition(config)


def _train_sr(config: "DictConfig") -> Path:
    from lrsr.sr.training import train

    if "module" not in config.sr:
        raise InputError("nothing to train there: give sr=srcnn2x or sr=srcnn4x")
    section(IdentityRange, config, "identities")
    section(RenderingSettings, config, "rendering")
    seed = whole_number(config, "seed")
    folder = _run_folder()
    write_provenance(folder, config)
    return train(
        _instantiate(config.data),
        _instantiate(config.sr.module),
        folder=folder,
        trainer=_instantiate(config.trainer),
        callbacks=list(_instantiate(config.callbacks).values()),
        loggers=list(_instantiate(config.logger).values()),
        seed=seed,
        resume=bool(config.resume),
        about={"identities": config.identities.count, "ipd_px": numbers(config.data, "ipd_px")},
    )


def _train_recognition(config: "DictConfig") -> Path:
    from omegaconf import OmegaConf

    from lrsr.data.cache import RenderCache
    from lrsr.recognition.faces import FaceSettings
    from lrsr.recognition.training import TrainingSettings, train_embedder

    if "training" not in config.recognition:
        raise InputError("nothing to train there: give recognition=arcface")
    faces = section(FaceSettings, config.recognition, "faces")
    training = section(TrainingSettings, config.recognition, "training")
    folder = _run_folder()
    used = ("seed", "identities", "rendering", "camera", "paths", "recognition", "resume")
    write_provenance(folder, OmegaConf.masked_copy(config, list(used)))
    return train_embedder(
        folder,
        RenderCache(_cache(config)),
        faces=faces,
        training=training,
        resume=bool(config.resume),
    )


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
