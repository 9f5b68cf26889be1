"""What does ``lrsr fit-camera`` do? It finds a camera that takes pictures like a folder's."""

import logging
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from tqdm import tqdm

from lrsr.calibration.compression import CompressionEstimate, estimate_compression
from lrsr.calibration.fit import expected_trials, fit_camera
from lrsr.calibration.objective import LEAST_IMAGES
from lrsr.calibration.parameters import starting_from, with_jpeg, with_values
from lrsr.calibration.picture_statistics import crop
from lrsr.calibration.real_pictures import read_real_pictures
from lrsr.calibration.report import Finding, write_finding
from lrsr.calibration.strangers import render_strangers
from lrsr.camera.preset_file import build_camera
from lrsr.configuration import require
from lrsr.errors import InputError
from lrsr.files import write_text
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.pictures.sitting import Sitting
from lrsr.rendering.geometry import FRAME_IPDS

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class FitSettings:
    """Everything that ``lrsr fit-camera`` can be told.

    Attributes:
        images: Folder of the pictures.
        preset: Plain mapping of the camera that the search starts from; what is not fitted stays.
        strangers: 20 or more people, in pose, light, expression, lens and standpoint as of those
            in the pictures, as far as known; at 8 px: their size follows from ``ipd_px``.
        name: Of the new preset.
        ipd_px: Of the pictures, px; None: a quarter of their width.
        part: Share of the sides that counts, about the middle.
        rounds: Steps at most of the search's first, coarse part.

    Raises:
        InputError: A value is out of range.
    """

    images: Path
    preset: Mapping[str, Any]
    strangers: Sitting
    name: str = "fitted"
    ipd_px: float | None = None
    part: float = 0.75
    rounds: int = 12

    def __post_init__(self) -> None:
        plain = re.fullmatch(r"\w[\w-]*", self.name) is not None
        require(plain, "name", self.name, "letters, digits, _ and -")
        count = self.strangers.people.count
        require(count >= LEAST_IMAGES, "identities.count", count, f"at least {LEAST_IMAGES}")
        require(self.rounds >= 1, "rounds", self.rounds, "at least 1")
        require(0 < self.part <= 1, "part", self.part, "a share > 0 to 1")
        if self.ipd_px is not None:
            require(self.ipd_px >= 4, "ipd_px", self.ipd_px, "at least 4")


def fit_to_folder(
    settings: FitSettings,
    folder: Path,
    *,
    cache: RenderCache,
    maker: Maker | None = None,
    progress: bool = True,
) -> Path:
    """Fit; write ``results.json``, figures, ``report.html`` and, if it is of use, ``NAME.yaml``.

    Args:
        settings: What is asked.
        folder: Of the run.
        cache: Where renderings are kept.
        maker: Renders the strangers; Mitsuba when None.
        progress: Show a bar on stderr.

    Returns:
        ``folder``.

    Raises:
        InputError: The pictures cannot be used, a folder cannot be written, or the camera that was
            found is no better than the one that the search began with; then there is no preset,
            and the report says why.
    """
    real = read_real_pictures(settings.images, LEAST_IMAGES)
    crop(real.srgb, settings.part)  # refuses too small a part
    guess = starting_from(settings.preset)  # refuses a preset that cannot be fitted
    stored = CompressionEstimate(*real.jpeg, ((0, 0),)) if real.jpeg else None  # as the files say
    stored = stored or estimate_compression(real.srgb)
    quality, chroma = (stored.quality, stored.chroma) if stored else (None, "4:2:0")
    preset = with_jpeg(settings.preset, quality, chroma, (0, 0))
    strangers = render_strangers(
        settings.strangers,
        settings.ipd_px or max(4.0, real.size_px[1] / FRAME_IPDS),
        build_camera(preset).supersampling,
        cache=cache,
        maker=maker,
        progress=progress,
    ).cropped(real.size_px)
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
    began = with_values(preset, {one.name: one.start for one in guess})
    finding = Finding(fit, real, fitted, str(began.get("name")), tuple(origins_px))
    shown = {
        "Real": real.srgb,
        "Before": strangers.photographed(build_camera(began)),
        "After": strangers.photographed(build_camera(fitted)),
    }
    page = write_finding(folder, finding, shown, settings.strangers.seed)
    if finding.refusal is not None:
        raise InputError(f"images={settings.images}: {finding.refusal} (see {page})")
    write_text(folder / f"{settings.name}.yaml", _preset_text(finding))
    logger.info("camera=%s", folder / f"{settings.name}.yaml")
    return folder


def _preset_text(finding: Finding) -> str:
    """Return a preset as YAML, headed by how well each value is known."""
    from omegaconf import OmegaConf

    count = len(finding.real.srgb)
    lines = [
        f"# Fitted by lrsr fit-camera to {count} pictures; strangers, no references.",
        f"# The lens blurs as a Gaussian of {finding.blur_px:.2f} px.",
        "# Not to be told from such pictures: gain from full well, exposure from albedo.",
    ]
    for name, one in finding.fit.values.items():
        doubt = "" if one.known else ", mostly the guess: the pictures do not show it"
        lines.append(f"# {name} {one.value:.4g}, standard error {one.error:.2g}{doubt}")
    return "\n".join([*lines, OmegaConf.to_yaml(OmegaConf.create(dict(finding.preset)))])
