"""Tests of lrsr/pages.py."""

import base64
import io
import re

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from lrsr.errors import ImageContractError
from lrsr.pages import encode_face, png_bytes, svg_uri


def decode(uri: str) -> np.ndarray:
    kind, content = uri.split(",")
    assert kind == "data:image/webp;base64"
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(content))))


def test_a_face_keeps_every_pixel() -> None:
    face = np.random.default_rng(0).integers(0, 256, size=(3, 5, 7)) / 255
    assert decode(encode_face(face)) / 255 == pytest.approx(face.transpose(1, 2, 0), abs=1e-6)


def test_a_face_beyond_the_range_is_clipped_for_the_picture() -> None:
    face = np.stack([np.full((1, 1), value) for value in (-0.5, 0.5, 1.5)])
    assert decode(encode_face(face))[0, 0].tolist() == [0, 128, 255]


@pytest.mark.parametrize("shape", [(1, 4, 4), (4, 4), (1, 3, 4, 4), (3, 0, 4)])
def test_what_is_no_face_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ImageContractError, match="wanted"):
        encode_face(np.zeros(shape))


def test_a_face_with_a_nan_is_refused() -> None:
    with pytest.raises(ImageContractError, match="NaN"):
        encode_face(np.full((3, 2, 2), np.nan))


def outline(x: ArrayLike, y: ArrayLike, *, filled: bool = False) -> str:
    """Draw in a figure of 100 by 100 points, and return the outline in its SVG."""
    figure = Figure(figsize=(100 / 72, 100 / 72))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, 100), ylim=(0, 100))
    axes.set_axis_off()
    (axes.fill if filled else axes.plot)(x, y)
    svg = base64.b64decode(svg_uri(figure).partition(",")[2]).decode()
    drawn: list[str] = re.findall(r' d="([^"]*)"', svg)
    return max(drawn, key=len)


def corners(drawn: str) -> NDArray[np.float64]:
    """Read a relative outline; y upwards."""
    places, at = [], np.zeros(2)
    for letter, numbers in re.findall(r"([Mlhv])([^Mlhvz]*)", drawn):
        given = [float(number) for number in numbers.split()]
        step = {"h": [*given, 0.0], "v": [0.0, *given]}.get(letter, given)
        at = np.array(step) if letter == "M" else at + step
        places.append((at[0], 100 - at[1]))
    return np.array(places)


def farthest(points: NDArray[np.float64], line: NDArray[np.float64]) -> float:
    """Return how far a point is from a line of corners, at most."""
    start, along = line[:-1], np.diff(line, axis=0)
    away = points[:, None] - start
    way = ((away * along).sum(-1) / np.maximum((along**2).sum(-1), 1e-12)).clip(0, 1)
    return float(np.linalg.norm(away - way[..., None] * along, axis=-1).min(axis=1).max())


def staircase(steps: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    way = np.linspace(0, 1, steps + 1)
    return np.repeat(100 * way, 2)[1:-1], np.repeat(100 * np.sqrt(way), 2)[:-2]


@pytest.mark.parametrize("steps", [3, 40, 2000])
def test_a_curve_keeps_what_can_be_seen_of_it(steps: int) -> None:
    given = np.column_stack(staircase(steps))
    kept = corners(outline(*staircase(steps)))
    assert farthest(given, kept) < 0.25
    assert farthest(kept, given) < 0.25


def test_steps_that_cannot_be_seen_are_left_out() -> None:
    assert len(outline(*staircase(2000))) < 3000
    assert len(corners(outline(*staircase(40)))) == 80


def test_a_filled_shape_stays_closed_and_whole() -> None:
    turn = np.linspace(0, 2 * np.pi, 1000)
    x, y = 50 + 40 * np.cos(turn), 50 + 40 * np.sin(turn)
    drawn = outline(x, y, filled=True)
    assert drawn.endswith("z")
    around = corners(drawn)
    assert farthest(np.column_stack((x, y)), np.vstack((around, around[:1]))) < 0.25
    assert len(around) < 200


@pytest.mark.parametrize("name", ["$a_{$", r"$\foo$", "$5 or $6"])
def test_a_dollar_in_a_name_is_a_dollar(name: str) -> None:
    figure = Figure()
    axes = figure.subplots()
    axes.plot([1, 1000], [0, 1], label=name)
    axes.set(xscale="log", title=name, ylabel=name)
    axes.set_yticks([0, 1], [name, name])
    axes.legend(title=name)
    assert png_bytes(figure)[:4] == b"\x89PNG"
    assert svg_uri(figure).startswith("data:image/svg+xml")
    label = axes.xaxis.majorTicks[0].label1
    assert label.get_text().startswith("$")  # a power of ten
    assert label.get_parse_math()
