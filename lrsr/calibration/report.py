"""What does a reader get of a fitted camera? Values with doubts; faces before and after."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, ScalarFormatter

from lrsr.calibration.fit import Fit
from lrsr.calibration.parameters import lens_blur_px
from lrsr.calibration.picture_statistics import BENT_NAMES, GROUPS, RANGES, RINGS
from lrsr.calibration.real_pictures import RealPictures
from lrsr.camera.preset_file import build_camera
from lrsr.files import write_bytes, write_json
from lrsr.pages import COLOURS, DPI, STYLE, encode_face, png_bytes, png_uri, write_page
from lrsr.provenance import versions

_SHOWN = 8
"""Faces of each kind: the first ones, not chosen."""

_DONE = (
    "Rendered people, other than those of the pictures, were photographed with trial cameras until "
    "the means of the statistics below agreed with those of the pictures (method of simulated "
    "moments).",
    "JPEG quality, grid and chroma sub-sampling were found first: from the headers of JPEG files, "
    "else from the combs in the histograms of DCT coefficients.",
)
_NOT_DONE = (
    "The pictures are not compared one by one: nobody knows what they should look like.",
    "Exposure is known only together with the albedo of the people in the pictures, contrast with "
    "their lighting; the cast is relative to the rendered population's skin, hair and light.",
    "Read noise is a share of white; in electrons it is as uncertain as the electrons at white. "
    "Gain and full well cannot be told apart. What the codec removed is not known at all.",
    "Blur is given to the lens as defocus, whatever its cause; width of the sharpening, denoising, "
    "mosaic, colour matrix, fixed pattern, and every compression but the last are those of the "
    "camera that the search began with.",
    "Standard errors are of first order and hold if the rendered population, pose and light are "
    "like those of the pictures.",
)


@dataclass(frozen=True)
class Finding:
    """A camera that was fitted, and what to.

    Attributes:
        fit: How well its statistics agree with those of the pictures.
        real: The pictures.
        preset: Plain mapping of the fitted camera.
        guess: Name of the camera that the search began with.
        origins_px: Places of the pictures' first pixels in the grids of their files.
    """

    fit: Fit
    real: RealPictures
    preset: Mapping[str, Any]
    guess: str
    origins_px: tuple[tuple[int, int], ...]

    @cached_property
    def blur_px(self) -> float:
        """Of the lens, σ of a Gaussian."""
        return lens_blur_px(build_camera(self.preset))

    @property
    def refusal(self) -> str | None:
        """Why this camera is of no use, and what to do; None if it is of some."""
        fit, count = self.fit, len(self.real.srgb)
        remedy = f"give more than {count} pictures, of more people and with more detail"
        if not any(one.known for one in fit.values.values()):
            return f"they show nothing of the camera, all values are the guess; no preset; {remedy}"
        if not fit.misfit_after <= fit.misfit_before:
            grown = f"the misfit has grown from {fit.misfit_before:.2f} to {fit.misfit_after:.2f}"
            return f"{grown}; no preset; take camera={self.guess} as it is, or {remedy}"
        return None


def write_finding(
    folder: Path, finding: Finding, pictures: Mapping[str, torch.Tensor], seed: int
) -> Path:
    """Write ``results.json``, ``statistics.png`` and ``report.html``, which holds every picture.

    Args:
        folder: Of the run.
        finding: What was found.
        pictures: Real, before, after: ``(n, 3, H, W)`` each.
        seed: Of the noise.

    Returns:
        Path of the page.

    Raises:
        InputError: The folder cannot be written.
    """
    figure, fit = _draw_fit(finding.fit), finding.fit
    means = (fit.measured, fit.before, fit.after, fit.spread)
    rows = dict(zip(BENT_NAMES, np.stack(means, 1).tolist(), strict=True))
    write_json(folder / "results.json", _results(finding, rows))
    write_bytes(folder / "statistics.png", figure)
    return write_page(
        folder,
        "fit_camera",
        title=f"Camera {finding.preset['name']}",
        question="Which camera took these pictures?",
        answer=_answer(finding),
        figure=png_uri(figure),
        columns={
            label: [encode_face(face) for face in column[:_SHOWN].numpy()]
            for label, column in pictures.items()
        },
        fit=fit,
        statistics=rows,
        done=_DONE,
        not_done=_NOT_DONE,
        versions=versions(),
        seed=seed,
    )


def _results(finding: Finding, rows: Mapping[str, Sequence[float]]) -> dict[str, Any]:
    fit, real, preset = finding.fit, finding.real, dict(finding.preset)
    kinds = ("real", "before", "after", "spread")
    return {
        "pictures": len(real.srgb),
        "copies": dict(real.copies),
        "size_px": list(real.size_px),
        "values": {name: asdict(value) for name, value in fit.values.items()},
        "blur_px": finding.blur_px,
        "read_noise_e": asdict(fit.product("read_noise", "white_e")),
        "jpeg": preset["stored"],
        "origin_px": preset["origin_px"],
        "origins_px": [list(place) for place in finding.origins_px],
        "misfit": {"before": fit.misfit_before, "after": fit.misfit_after},
        "statistics": {name: dict(zip(kinds, row, strict=True)) for name, row in rows.items()},
        "trials": fit.trials,
        "refusal": finding.refusal,
        "preset": preset,
    }


def _answer(finding: Finding) -> list[str]:
    """Return what was found, in sentences."""
    fit, real = finding.fit, finding.real
    values, electrons = fit.plain, fit.product("read_noise", "white_e")
    unknown = [name for name, fitted in fit.values.items() if not fitted.known]
    sentences = [
        f"{len(real.srgb)} pictures of {real.size_px[1]} × {real.size_px[0]} px: the lens blurs as "
        f"a Gaussian of {finding.blur_px:.2f} px; sharpening {values['sharpen_amount']:.2f}.",
        f"Read noise is {100 * values['read_noise']:.2g} % of white ({electrons.value:.3g} ± "
        f"{electrons.error:.2g} of {values['white_e']:.0f} electrons).",
        f"Gains over green: red {values['cast_red']:.3f}, blue {values['cast_blue']:.3f}; contrast "
        f"{values['contrast']:.2f}, saturation {values['saturation']:.2f}.",
        _kept(finding),
        f"Mean square of the whitened differences: {fit.misfit_before:.1f} before, "
        f"{fit.misfit_after:.2f} after; chance gives about 1.",
    ]
    if finding.refusal is not None:
        sentences.insert(0, f"Not to be used: {finding.refusal}.")
    if real.copies:
        sentences.append(f"{len(real.copies)} further files were copies and left out.")
    if unknown:
        sentences.append(f"Mostly the guess, as the pictures do not show it: {', '.join(unknown)}.")
    return sentences


def _kept(finding: Finding) -> str:
    stored, (x, y) = finding.preset["stored"], finding.preset["origin_px"]
    if stored is None:
        return "No JPEG blocks were found."
    grids = len({(x % 8, y % 8) for x, y in finding.origins_px})
    place = f"grid from ({-x % 8}, {-y % 8}) on" if grids == 1 else f"{grids} grids of blocks"
    source = "say the files" if finding.real.jpeg is not None else "from the pixels"
    return f"JPEG quality {stored['qualities']}, colours {stored['chroma']}, {place}, {source}."


_BELOW: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": 6}


def _draw_fit(fit: Fit) -> bytes:
    """Draw the spectrum, the noise and all differences, before and after, as a PNG."""
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 5.0), dpi=DPI, layout="constrained")
        spectrum, noise, differences = figure.subplot_mosaic([["a", "b"], ["c", "c"]]).values()
        middles = (np.array(RINGS[1:]) + np.array(RINGS[:-1])) / 2
        rings, ranges = slice(0, len(middles)), slice(len(middles), len(middles) + RANGES)
        kinds = (("real", fit.measured, 0), ("before", fit.before, 4), ("after", fit.after, 2))
        for label, means, colour in kinds:
            line: dict[str, Any] = {"label": label, "color": COLOURS[colour], "marker": "o"}
            line |= {"markersize": 3}
            spectrum.plot(middles, means[rings] / np.log(10), **line)
            noise.plot(range(1, RANGES + 1), np.exp(means[ranges] / 2), **line)
            if label != "real":
                away = (means - fit.measured) / fit.spread
                differences.plot(np.arange(len(BENT_NAMES)), away, **{**line, "linestyle": ""})
        spectrum.set(xlabel="Cycles per pixel", ylabel="log₁₀ power", title="Spectrum")
        noise.set(xlabel="Quarter of brightness", ylabel="Levels of 255", title="Noise")
        noise.set_xticks(range(1, RANGES + 1))
        noise.set_ylim(bottom=0)
        differences.axhspan(-2, 2, color="#dddddd", linewidth=0)
        differences.axhline(0, color="black", linewidth=0.6)
        _name_groups(differences)
        differences.set_yscale("symlog", linthresh=3)
        differences.yaxis.set_major_locator(FixedLocator([-100, -30, -10, -2, 0, 2, 10, 30, 100]))
        differences.yaxis.set_major_formatter(ScalarFormatter())
        differences.set(ylabel="Difference from real, in σ of chance", title="Every statistic")
        spectrum.legend()
        return png_bytes(figure)


def _name_groups(axes: Axes) -> None:
    """Write below the axes which kinds of statistics follow each other, with lines in between."""
    start = 0
    for label, names in GROUPS.items():
        end = start + len(names)
        axes.text(
            (start + end - 1) / 2, -0.03, label, **_BELOW, transform=axes.get_xaxis_transform()
        )
        axes.axvline(end - 0.5, color="#999999", linewidth=0.5)
        start = end
    axes.set_xticks([])
    axes.set_xlim(-1, start)
