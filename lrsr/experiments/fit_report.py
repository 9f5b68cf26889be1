"""What does a reader get of a fitted camera? Values with doubts; faces before and after."""

from collections.abc import Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import torch
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lrsr.camera.fitting import Fit
from lrsr.camera.statistics import BENT_NAMES, RANGES, RINGS
from lrsr.experiments.real_pictures import RealPictures
from lrsr.experiments.report.figures import COLOURS, DPI, STYLE, data_uri, encode_face, png_bytes
from lrsr.experiments.report.page import FILE, template
from lrsr.files import write_bytes, write_text
from lrsr.provenance import versions

SHOWN = 8
"""Faces of each kind: the first ones, not chosen."""

DONE = (
    "Rendered people, other than those of the pictures, were photographed with trial cameras until "
    "the means of the statistics below agreed with those of the pictures (method of simulated "
    "moments).",
    "JPEG quality, grid and chroma sub-sampling were found first: from the headers of JPEG files, "
    "else from the combs in the histograms of DCT coefficients.",
)
NOT_DONE = (
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


def write_fit_report(
    folder: Path,
    name: str,
    fit: Fit,
    real: RealPictures,
    preset: Mapping[str, Any],
    blur_px: float,
    grids: int,
    pictures: Mapping[str, torch.Tensor],
    seed: int,
) -> Path:
    """Write ``statistics.png`` and ``report.html``, which holds every picture.

    Args:
        folder: Of the run.
        name: Of the preset.
        fit: What was found.
        real: The pictures.
        preset: Plain mapping of the fitted camera.
        blur_px: Of its lens, σ of a Gaussian.
        grids: How many grids of blocks the pictures have; 1 if it is the preset's.
        pictures: Real, before, after: ``(n, 3, H, W)`` each.
        seed: Of the noise.

    Returns:
        Path of the page.

    Raises:
        InputError: The folder cannot be written.
    """
    figure = draw_fit(fit)
    write_bytes(folder / "statistics.png", figure)
    made_by = versions()
    page = template("fit_camera.html.j2").render(
        title=f"Camera {name}",
        answer=answer(fit, real, preset, blur_px, grids),
        figure=data_uri(figure),
        columns=[
            {"label": label, "faces": [encode_face(face) for face in column[:SHOWN].numpy()]}
            for label, column in pictures.items()
        ],
        lines=[
            {
                "name": parameter.name,
                "says": parameter.says,
                "start": f"{parameter.start:.4g}",
                "value": f"{fit.values[parameter.name].value:.4g}",
                "error": f"{fit.values[parameter.name].error:.2g}",
                "known": fit.values[parameter.name].known,
            }
            for parameter in fit.parameters
        ],
        statistics=[
            {"name": column, "values": [f"{value:.3f}" for value in row]}
            for column, row in zip(
                BENT_NAMES,
                zip(fit.measured, fit.before, fit.after, fit.spread, strict=True),
                strict=True,
            )
        ],
        done=DONE,
        not_done=NOT_DONE,
        versions=made_by,
        commit=made_by["git"],
        seed=seed,
    )
    write_text(folder / FILE, page)
    return folder / FILE


def answer(
    fit: Fit, real: RealPictures, preset: Mapping[str, Any], blur_px: float, grids: int = 1
) -> list[str]:
    """Return what was found, in sentences."""
    values, stored = fit.plain, preset["stored"]
    electrons = fit.product("read_noise", "white_e")
    kept = "No JPEG blocks were found."
    if stored is not None:
        x, y = preset["origin_px"]
        source = "say the files" if real.jpeg is not None else "from the pixels"
        place = f"grid from ({-x % 8}, {-y % 8}) on" if grids == 1 else f"{grids} grids of blocks"
        quality, chroma = stored["qualities"], stored["chroma"]
        kept = f"JPEG quality {quality}, colours {chroma}, {place}, {source}."
    unknown = [name for name, fitted in fit.values.items() if not fitted.known]
    sentences = [
        f"{len(real.srgb)} pictures of {real.size_px[1]} × {real.size_px[0]} px: the lens blurs as "
        f"a Gaussian of {blur_px:.2f} px; sharpening {values['sharpen_amount']:.2f}.",
        f"Read noise is {100 * values['read_noise']:.2g} % of white ({electrons.value:.3g} ± "
        f"{electrons.error:.2g} of {values['white_e']:.0f} electrons).",
        f"Gains over green: red {values['cast_red']:.3f}, blue {values['cast_blue']:.3f}; contrast "
        f"{values['contrast']:.2f}, saturation {values['saturation']:.2f}.",
        kept,
        f"Mean square of the whitened differences: {fit.misfit_before:.1f} before, "
        f"{fit.misfit_after:.2f} after; chance gives about 1.",
    ]
    if unknown:
        sentences.append(f"Mostly the guess, as the pictures do not show it: {', '.join(unknown)}.")
    return sentences


_KINDS = {
    "log_power_": "spectrum",
    "log_noise_": "noise",
    "log_band_luma_": "cosines of luminance",
    "log_band_red_": "cosines of red",
    "log_band_blue_": "cosines of blue",
}
_BELOW: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": 6}


def draw_fit(fit: Fit) -> bytes:
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
        differences.set(ylabel="Difference from real, in σ of chance", title="Every statistic")
        spectrum.legend()
        return png_bytes(figure)


def _name_groups(axes: Axes) -> None:
    """Write below the axes which kinds of statistics follow each other, with lines in between."""
    start = 0
    for label, names in groupby(BENT_NAMES, _kind):
        end = start + len(list(names))
        axes.text(
            (start + end - 1) / 2, -0.03, label, **_BELOW, transform=axes.get_xaxis_transform()
        )
        axes.axvline(end - 0.5, color="#999999", linewidth=0.5)
        start = end
    axes.set_xticks([])
    axes.set_xlim(-1, start)


def _kind(name: str) -> str:
    named = (label for prefix, label in _KINDS.items() if name.startswith(prefix))
    return next(named, "quantiles" if name.split("_")[-1].isdigit() else "colours")
