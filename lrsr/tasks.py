"""What does each command do with its composed configuration? It hands plain values to one function.

Every task returns the folder that holds its result; the command line prints it last.
"""

import logging
import sys
from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lrsr.configuration import (
    as_word,
    flag,
    number,
    require,
    run_folder,
    seed_of,
    whole_number,
    whole_numbers,
    words,
)
from lrsr.errors import InputError
from lrsr.files import make_folder
from lrsr.paths import cache_folder, models_folder, path_if_any, user_path
from lrsr.presets import build
from lrsr.provenance import write_provenance

if TYPE_CHECKING:
    from omegaconf import DictConfig

    from lrsr.pictures.cache import RenderCache

logger = logging.getLogger(__name__)


def run_eval(config: "DictConfig") -> Path:
    """Run an experiment: the class that its ``_target_`` names.

    Raises:
        InputError: A setting is wrong; nothing has been rendered by then.
    """
    from hydra.utils import get_class  # loaded by then

    _refuse_unread(config)
    kind: Any = get_class(str(config._target_))
    unread = getattr(kind, "unread", ())
    if unread := unread(config) if callable(unread) else unread:
        _refuse(unread, f"experiment={config.name} does not read it; leave it")
    experiment = kind.from_config(config)
    with run_folder(config) as folder:
        write_provenance(folder, config)
        result: Path = experiment.run(folder, _cache(config))
        return result


run_demo = run_eval


def run_score(config: "DictConfig") -> Path:
    """Evaluate scores of files; see :mod:`lrsr.evaluation.score_files`.

    Raises:
        InputError: A setting is wrong, or a file holds no scores that can be evaluated.
    """
    from lrsr.experiments.scoring import Scoring

    scoring = Scoring.from_config(config)
    with run_folder(config) as folder:
        write_provenance(folder, config)
        return scoring.run(folder)


def run_compare(config: "DictConfig") -> Path | None:
    """Print how alike two pictures are, and what that is worth; see :mod:`lrsr.experiments.pair`.

    Returns:
        The file of the result, if ``out`` names one.

    Raises:
        InputError: A setting is wrong, a picture cannot be read, or the scores do not fit.
    """
    from hydra.core.hydra_config import HydraConfig  # loaded by then

    from lrsr.experiments.pair import PairComparison, lines_of

    chosen = str(HydraConfig.get().runtime.choices["sr"])
    asked = PairComparison.from_config(config, method=chosen)
    for line in lines_of(asked.run()):
        sys.stdout.write(f"{line}\n")
    return asked.out


def run_upscale(config: "DictConfig") -> Path:
    """Enlarge pictures; see :mod:`lrsr.experiments.upscaling`.

    Raises:
        InputError: A setting is wrong, or there are no pictures.
        ExceptionGroup: Of InputErrors: some pictures were refused; the others are finished.
    """
    from lrsr.experiments.upscaling import Upscaling

    if path_if_any(config.out, "out") is None:
        raise InputError("out=null: give the folder for the pictures, e.g. out=larger")
    upscaling = Upscaling.from_config(config)
    with run_folder(config) as folder:
        write_provenance(folder, config)
        return upscaling.run(folder)


def run_identities(config: "DictConfig") -> Path:
    """Check that people differ, or export them where ``export`` names a folder.

    Raises:
        InputError: A setting is wrong, or would not be read.
    """
    _refuse_enrolled(config)
    out = path_if_any(config.export, "export")
    if out is None:
        _refuse(_OF_EXPORTS, "only export=DIR reads it; leave it")
        _refuse([_SAMPLES], "enrolled pictures have gallery.samples_per_pixel; give that")
        return run_eval(config)
    _refuse(_OF_THE_CHECK, "export=DIR does not read it; leave it")
    from omegaconf import OmegaConf

    from lrsr.pictures.export import export_to_folder
    from lrsr.pictures.sitting import read_probes
    from lrsr.pictures.to_folder import RenderSettings
    from lrsr.rendering.scene import Film

    settings = RenderSettings(
        out=out,
        sitting=read_probes(config, Film(number(config, "ipd_px"))),
        camera=build(config.camera, "camera"),
        camera_settings=OmegaConf.to_container(config.camera, resolve=True),  # type: ignore[arg-type]  # a mapping
    )
    make_folder(out)
    export_to_folder(settings, _cache(config))
    write_provenance(out, config)
    return out


_OF_PROBES = (
    *("ipd_px", "options", "conditions", "lens", "standpoint", "camera"),
    *("expression", "another_day", "burst"),
)
_OF_PEOPLE = ("identities", "rendering")
_OF_SCENES = (
    *("pose", "lighting", "lens", "standpoint", "expression", "another_day"),
    *("ipd_px", "compression", "burst"),
)
_SAMPLES = "rendering.samples_per_pixel"
_OF_EXPORTS = ("pose", "lighting", "expression", "another_day", "ipd_px", "lens", "standpoint")
_OF_THE_CHECK = ("gallery", "recognition", "encoder", "smallest_angle_deg", "most_redraws")


def _refuse(unread: Collection[str], why: str) -> None:
    """Refuse what was typed and would not be read.

    Raises:
        InputError: Something was.
    """
    for key in _typed_of(unread):
        raise InputError(f"{key}: {why}")


def _refuse_unread(config: "DictConfig") -> None:
    """Refuse what was typed about rendering where photographs take its place.

    Raises:
        InputError: A setting would not be read.
    """
    from omegaconf import OmegaConf

    keys = ("probes", "gallery")
    folders = [key for key in keys if OmegaConf.select(config, f"{key}.folder") is not None]
    unread = [*(_OF_PROBES if "probes" in folders else ()), *(_OF_PEOPLE if folders[1:] else ())]
    typed = [("probes", key) for key in _typed_of(unread)]
    if "gallery" in folders:
        typed += [("gallery", key) for key in _typed_of(["gallery"]) if key != "gallery.folder"]
    for folder, key in typed:
        raise InputError(f"{key}: photographs in {folder}.folder are as they are; leave it")


def _refuse_enrolled(config: "DictConfig") -> None:
    """Refuse photographs as enrolled pictures where nobody is compared with them.

    Raises:
        InputError: They were asked for.
    """
    enrolled = as_word(config.identities.gallery, "identities.gallery")
    wish = "render: only lrsr eval enrols photographs"
    require(enrolled == "render", "identities.gallery", enrolled, wish)


def _tell_unread(kind: str) -> None:
    """Say which words of ``lrsr render`` change nothing, as enrolled pictures have their own."""
    unread = (*_OF_SCENES, _SAMPLES) if kind == "gallery" else ("gallery",)
    for key in _typed_of(unread):
        logger.warning(
            "%s changes nothing where kind=%s (gallery.* is for kind=gallery)", key, kind
        )


def _typed_of(sections: Collection[str]) -> list[str]:
    """Return which of some settings, or of those within them, were typed."""
    from hydra.core.hydra_config import HydraConfig  # loaded by then

    keys = [word.lstrip("+~").partition("=")[0] for word in HydraConfig.get().overrides.task]
    within = tuple(f"{section}." for section in sections)
    return [key for key in keys if f"{key.replace('/', '.')}.".startswith(within)]


def run_render(config: "DictConfig") -> Path:
    """Write probes or the gallery as PNG files with a manifest; see :mod:`lrsr.pictures.to_folder`.

    Raises:
        InputError: A setting is wrong.
    """
    from omegaconf import OmegaConf

    from lrsr.pictures.sitting import read_gallery, read_probes
    from lrsr.pictures.to_folder import RenderSettings, render_to_folder
    from lrsr.rendering.scene import Film

    _refuse_enrolled(config)
    out = path_if_any(config.out, "out")
    if out is None:
        raise InputError("out=null: give the folder for the pictures, e.g. out=probes")
    settings = RenderSettings(
        out=out,
        sitting=(
            read_gallery(config)
            if config.kind == "gallery"
            else read_probes(config, Film(number(config, "ipd_px")), config.kind)
        ),
        camera=build(config.camera, "camera"),
        camera_settings=OmegaConf.to_container(config.camera, resolve=True),  # type: ignore[arg-type]  # a mapping
        compression=as_word(config.compression, "compression"),
        scales=whole_numbers(config, "scales"),
        frames=whole_number(config, "frames"),
        png16=flag(config, "png16"),
    )
    _tell_unread(str(config.kind))
    make_folder(out)
    folder = render_to_folder(settings, _cache(config)).parent
    write_provenance(folder, config)
    return folder


def run_models(config: "DictConfig") -> Path:
    """Say which networks of other people are here and could be, and bring, check or remove them.

    Raises:
        InputError: There is no such action or model, or it cannot be had or used.
    """
    from lrsr.recognition.addition import add
    from lrsr.recognition.delivery import CONSENTS, Wish, pull
    from lrsr.recognition.store import remove, table, verify

    names, accept = words(config, "names"), words(config, "accept")
    for word in accept:
        require(word in CONSENTS, "accept", word, f"one of {', '.join(CONSENTS)}")
    told = {
        key: "" if config[key] is None else as_word(config[key], key)
        for key in ("sha256", "contract", "name", "licence", "source")
    }
    mirror = config.models.mirror
    mirror = "" if mirror is None else as_word(mirror, "models.mirror")
    wish = Wish(accept, told.pop("sha256"), mirror)
    does: dict[str, Callable[[], list[str]]] = {
        "list": table,
        "verify": lambda: verify(names),
        "pull": lambda: [line for name in names for line in pull(name, wish)],
        "add": lambda: [add(user_path(name), **told) for name in names],
        "remove": lambda: [line for name in names for line in remove(name)],
    }
    action = as_word(config.action, "action")
    require(action in does, "action", action, f"one of {', '.join(does)}")
    needed = action in ("pull", "add", "remove")
    require(bool(names) or not needed, "names", [], f"lrsr models {action} NAME")
    require(action != "list" or not names, "names", names, "none: lrsr models list")
    for line in does[action]():
        sys.stdout.write(f"{line}\n")
    return models_folder()


def run_reconstruct(config: "DictConfig") -> Path:
    """Turn photographs into people; see :mod:`lrsr.experiments.reconstruction`.

    Raises:
        InputError: A setting is wrong, or there are no pictures.
    """
    from lrsr.experiments.reconstruction import Reconstructing

    if path_if_any(config.out, "out") is None:
        raise InputError("out=null: give the folder for the people, e.g. out=heads")
    asked = Reconstructing.from_config(config)
    with run_folder(config) as folder:
        write_provenance(folder, config)
        return asked.run(folder, _cache(config))


def run_generate(config: "DictConfig") -> Path:
    """Photograph people whom a network makes up; see :mod:`lrsr.experiments.generation`.

    Raises:
        InputError: A setting is wrong or would not be read, or too few people can be made.
    """
    from lrsr.experiments.generation import Generating

    if path_if_any(config.out, "out") is None:
        raise InputError("out=null: give the folder for the people, e.g. out=people")
    if config.boundaries is not None:
        _refuse(("learning", "attributes"), "boundaries=FILE has learned them; leave it")
    asked = Generating.from_config(config)
    with run_folder(config) as folder:
        write_provenance(folder, config)
        return asked.run(folder)


def run_calibrate_reconstructor(config: "DictConfig") -> Path:
    """Calibrate a landmark network; see :mod:`lrsr.calibration.landmark_correspondence`.

    Raises:
        InputError: A setting is wrong, or the network cannot be used.
    """
    from lrsr.calibration.landmark_correspondence import Calibrating  # Mitsuba takes seconds

    asked = Calibrating.from_config(config)
    with run_folder(config) as folder:
        write_provenance(folder, config)
        return asked.run(folder, _cache(config))


def run_fit_camera(config: "DictConfig") -> Path:
    """Estimate a camera from real pictures; see :mod:`lrsr.calibration.from_pictures`.

    Raises:
        InputError: A setting is wrong, the pictures cannot be used, or show nothing.
    """
    from omegaconf import OmegaConf

    from lrsr.calibration.from_pictures import FitSettings, fit_to_folder  # torch takes seconds
    from lrsr.pictures.sitting import read_probes
    from lrsr.rendering.scene import Film

    settings = FitSettings(
        images=user_path(config.images, "images"),
        preset=OmegaConf.to_container(config.camera, resolve=True),  # type: ignore[arg-type]  # a mapping
        strangers=read_probes(config, Film()),
        name=as_word(config.name, "name"),
        ipd_px=None if config.ipd_px is None else number(config, "ipd_px"),
        part=number(config, "part"),
        rounds=whole_number(config, "rounds"),
    )
    with run_folder(config) as folder:
        write_provenance(folder, config)
        return fit_to_folder(settings, folder, cache=_cache(config))


def _those_of(config: "DictConfig", group: str) -> list[Any]:
    """Build the members of a group that are not null."""
    return [one for one in build(config[group], group).values() if one is not None]


def run_train(config: "DictConfig") -> Path:
    """Train the network of ``conf/train/NAME.yaml``; see :mod:`lrsr.training.run`.

    Raises:
        InputError: A setting is wrong, or the folder holds a run that depends on something else;
            nothing has been written by then.
    """
    from omegaconf import OmegaConf

    if config.get("module") is None:
        raise InputError(
            "what to train? give one of sr=srcnn4x, sr=fsrcnn4x, sr=edsr4x, sr=imdn4x,"
            " sr=sparnet4x, each for 2x, too, sr=fusion4x, recognition=arcface,"
            " recognition=mixed_resolution, reconstructor=position_map"
        )
    _refuse_enrolled(config)
    from lrsr.training.learner import Learner  # Lightning takes seconds
    from lrsr.training.lessons import read_lessons
    from lrsr.training.patchwork import Patchwork
    from lrsr.training.restoration import Restoration
    from lrsr.training.resume import refuse_other_run, what_matters
    from lrsr.training.run import train

    data = read_lessons(config, _cache(config))
    for section, why in data.unread.items():
        _refuse([section], why)
    plain: Any = OmegaConf.to_container(config, resolve=True)
    depends_on = what_matters(plain) | data.about()
    card = {}
    if isinstance(data, Patchwork) and "lr_made_by" not in config.module:
        card["lr_made_by"] = data.lr_made_by
    module = build(config.module, "module", **card)
    if isinstance(data, Patchwork) and isinstance(module, Restoration):
        module.try_patches(data.patches)  # nothing has been rendered by then
    resume = flag(config, "resume")
    steps = isinstance(module, Learner)
    depends_on |= module.about() if steps else {}
    for key in () if steps else ("trainer", "callbacks", "logger"):
        wish = "null, as what has a closed form is learned at once"
        require(config[key] is None, key, config[key], wish)
    with run_folder(config) as folder:
        if resume:
            longer = steps and module.follows_length
            refuse_other_run(folder, depends_on, follows_length=longer)
        if not steps:
            write_provenance(folder, config)
            done: Path = module.train(data, folder=folder, resume=resume, depends_on=depends_on)
            return done
        return train(
            module,
            data,
            folder=folder,
            trainer=build(config.trainer, "trainer"),
            callbacks=_those_of(config, "callbacks"),
            loggers=_those_of(config, "logger"),
            seed=seed_of(config),
            resume=resume,
            depends_on=depends_on,
            record=lambda folder: write_provenance(folder, config),
        )


def _cache(config: "DictConfig") -> "RenderCache":
    from lrsr.pictures.cache import RenderCache

    folder = path_if_any(config.paths.cache, "paths.cache") or cache_folder()
    return RenderCache(folder, whole_number(config, "processes"))
