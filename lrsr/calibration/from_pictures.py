"""What does ``lrsr fit-camera`` do? It finds a camera that takes pictures like a folder's."""

import logging
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import torch
from tqdm import tqdm

from lrsr.calibration.compression import CompressionEstimate, estimate_compression
from lrsr.calibration.fit import Fit, expected_trials, fit_camera
from lrsr.calibration.objective import LEAST_IMAGES
from lrsr.calibration.parameters import starting_from, with_jpeg, with_values
from lrsr.calibration.picture_statistics import BENT_NAMES as STATISTICS
from lrsr.calibration.picture_statistics import crop, lens_blur_px
from lrsr.calibration.real_pictures import RealPictures, read_real_pictures
from lrsr.calibration.report import write_fit_report
from lrsr.calibration.strangers import Strangers, camera_of
from lrsr.camera.camera import Camera
from lrsr.configuration import number, require, seed_of, whole_number
from lrsr.files import write_json, write_text
from lrsr.identities.roster import IdentityRange
from lrsr.paths import user_path
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.pictures.render import filmed, load_radiances, render_missing
from lrsr.pictures.sitting import Sitting, read_people, read_quality, read_scene
from lrsr.rendering.geometry import FRAME_IPDS
from lrsr.rendering.scene import Film, Quality, Scene

if TYPE_CHECKING:
    from omegaconf import DictConfig

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class FitSettings:
    """Everything that ``lrsr fit-camera`` can be told.

    Attributes:
        images: Folder of the pictures.
        preset: Plain mapping of the camera that the search starts from; what is not fitted stays.
        people: The strangers that are rendered, 20 or more.
        scene: Of the strangers, as far as known of the people in the pictures.
        quality: How well a film of 8 px is rendered.
        name: Of the new preset.
        ipd_px: Of the pictures, px; None: a quarter of their width.
        part: Share of the sides that counts, about the middle.
        rounds: Steps at most of the search's first, coarse part.
        seed: Of samplers and noise.

    Raises:
        InputError: A value is out of range.
    """

    images: Path
    preset: Mapping[str, Any]
    people: IdentityRange
    scene: Scene
    quality: Quality
    name: str = "fitted"
    ipd_px: float | None = None
    part: float = 0.75
    rounds: int = 12
    seed: int = 0

    def __post_init__(self) -> None:
        plain = re.fullmatch(r"\w[\w-]*", self.name) is not None
        require(plain, "name", self.name, "letters, digits, _ and -")
        count = self.people.count
        require(count >= LEAST_IMAGES, "identities.count", count, f"at least {LEAST_IMAGES}")
        require(self.rounds >= 1, "rounds", self.rounds, "at least 1")
        require(0 < self.part <= 1, "part", self.part, "a share > 0 to 1")
        if self.ipd_px is not None:
            require(self.ipd_px >= 4, "ipd_px", self.ipd_px, "at least 4")


def fit_settings(config: "DictConfig") -> FitSettings:
    """Read the settings of ``lrsr fit-camera`` from its composed configuration.

    Raises:
        InputError: A value is out of range; the message names the setting and the remedy.
    """
    from omegaconf import OmegaConf

    preset = OmegaConf.to_container(config.camera, resolve=True)
    return FitSettings(
        images=user_path(config.images),
        preset={str(key): value for key, value in dict(preset).items()},  # type: ignore[arg-type]
        people=read_people(config),
        scene=read_scene(config),
        quality=read_quality(config),
        name=str(config.name),
        ipd_px=None if config.ipd_px is None else number(config, "ipd_px"),
        part=number(config, "part"),
        rounds=whole_number(config, "rounds"),
        seed=seed_of(config),
    )


def fit_to_folder(
    settings: FitSettings,
    folder: Path,
    *,
    cache: RenderCache,
    maker: Maker | None = None,
    progress: bool = True,
) -> Path:
    """Fit; write ``NAME.yaml``, ``results.json``, figures and ``report.html``.

    Args:
        settings: What is asked.
        folder: Of the run.
        cache: Where renderings are kept.
        maker: Renders the strangers; Mitsuba when None.
        progress: Show a bar on stderr.

    Returns:
        ``folder``.

    Raises:
        InputError: The pictures cannot be used, or a folder cannot be written.
    """
    real = read_real_pictures(settings.images, LEAST_IMAGES)
    crop(real.srgb, settings.part)  # refuses too small a part
    guess = starting_from(settings.preset)  # refuses a preset that cannot be fitted
    stored = _compression(real)
    preset = _stored_like(settings.preset, stored)
    strangers = _render(settings, real, Strangers.supersampling_of(preset), cache, maker, progress)
    real = real.cropped(strangers.size_px)
    left, top = real.origin_px
    origins_px = [(x + left, y + top) for x, y in stored.origins_px] if stored else [(0, 0)]
    preset["origin_px"] = list(origins_px[0] if len(origins_px) == 1 else (0, 0))
    expected = expected_trials(rounds=settings.rounds)
    with tqdm(total=expected, desc="fitting", unit="trial", disable=not progress) as bar:

        def shoot(values: Mapping[str, float], draw: int) -> torch.Tensor:
            pictures = strangers.trial(with_values(preset, values), draw, origins_px)
            bar.update()
            return pictures

        fit = fit_camera(
            real.srgb, shoot, parameters=guess, part=settings.part, rounds=settings.rounds
        )
    fitted = {**with_values(preset, fit.plain), "name": settings.name}
    blur_px = lens_blur_px(camera_of(fitted))
    write_text(folder / f"{settings.name}.yaml", preset_text(fitted, fit, real, blur_px))
    results = _results(fit, real, blur_px, fitted) | {"origins_px": origins_px}
    write_json(folder / "results.json", results)
    pictures = {
        "Real": real.srgb,
        "Before": strangers.photographed(
            camera_of(with_values(preset, {one.name: one.start for one in guess}))
        ),
        "After": strangers.photographed(camera_of(fitted)),
    }
    grids = len({(x % 8, y % 8) for x, y in origins_px})
    write_fit_report(
        folder, settings.name, fit, real, fitted, blur_px, grids, pictures, settings.seed
    )
    logger.info("camera=%s", folder / f"{settings.name}.yaml")
    return folder


def preset_text(fitted: Mapping[str, Any], fit: Fit, real: RealPictures, blur_px: float) -> str:
    """Return a preset as YAML, headed by how well each value is known."""
    from omegaconf import OmegaConf

    lines = [
        f"# Fitted by lrsr fit-camera to {len(real.srgb)} pictures; strangers, no references.",
        f"# The lens blurs as a Gaussian of {blur_px:.2f} px.",
        "# Not to be told from such pictures: gain from full well, exposure from albedo.",
    ]
    for name, one in fit.values.items():
        doubt = "" if one.known else ", mostly the guess: the pictures do not show it"
        lines.append(f"# {name} {one.value:.4g}, standard error {one.error:.2g}{doubt}")
    return "\n".join([*lines, OmegaConf.to_yaml(OmegaConf.create(dict(fitted)))])


def _compression(real: RealPictures) -> CompressionEstimate | None:
    """Return the compression that the files, else the pixels, show."""
    if real.jpeg is not None:
        return CompressionEstimate(*real.jpeg, ((0, 0),))
    return estimate_compression(real.srgb)


def _stored_like(preset: Mapping[str, Any], stored: CompressionEstimate | None) -> dict[str, Any]:
    if stored is None:
        return with_jpeg(preset, None, "4:2:0", (0, 0))
    return with_jpeg(preset, stored.quality, stored.chroma, stored.origins_px[0])


def _render(
    settings: FitSettings,
    real: RealPictures,
    finer: int,
    cache: RenderCache,
    maker: Maker | None,
    progress: bool,
) -> Strangers:
    """Render who is not in the cache yet, and cut the films to the pictures' size."""
    camera = Camera(supersampling=finer)
    film = Film(settings.ipd_px or max(4.0, real.size_px[1] / FRAME_IPDS))
    sitting = Sitting(
        people=settings.people,
        scene=settings.scene,
        film=film,
        quality=settings.quality.at(film.ipd_px),
        seed=settings.seed,
    )
    recipes = [filmed(recipe, camera) for recipe in sitting.recipes()]
    render_missing(recipes, cache, progress=progress, maker=maker)
    radiances = load_radiances(recipes, cache, progress=progress, maker=maker)
    linear = torch.stack([radiance.image for radiance in radiances])
    metered = torch.tensor([radiance.metered for radiance in radiances])
    return Strangers(linear, metered, finer, settings.seed).cropped(real.size_px)


def _results(
    fit: Fit, real: RealPictures, blur_px: float, fitted: Mapping[str, Any]
) -> dict[str, Any]:
    return {
        "pictures": len(real.srgb),
        "size_px": list(real.size_px),
        "values": {name: asdict(value) for name, value in fit.values.items()},
        "blur_px": blur_px,
        "read_noise_e": asdict(fit.product("read_noise", "white_e")),
        "jpeg": fitted["stored"],
        "origin_px": fitted["origin_px"],
        "misfit": {"before": fit.misfit_before, "after": fit.misfit_after},
        "statistics": {
            name: {"real": real_, "before": before, "after": after, "spread": spread}
            for name, real_, before, after, spread in zip(
                STATISTICS,
                fit.measured.tolist(),
                fit.before.tolist(),
                fit.after.tolist(),
                fit.spread.tolist(),
                strict=True,
            )
        },
        "trials": fit.trials,
        "preset": dict(fitted),
    }
