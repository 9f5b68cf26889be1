"""Panoramas from files: light is kept, left stays left, broken files are refused in one line."""

from pathlib import Path

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.rendering.backend import _start
from lrsr.rendering.panorama import load_map


def write(path: Path, values: np.ndarray) -> Path:
    _start().Bitmap(np.ascontiguousarray(values, dtype=np.float32)).write(str(path))
    return path


def light_of(values: np.ndarray, *, on_lines: bool) -> np.ndarray:
    """Return the integral over the sphere of a map whose rows lie on or between latitudes."""
    height = len(values)
    if on_lines:
        lines = np.linspace(0, np.pi, height)
        cuts = np.concatenate([[0], (lines[1:] + lines[:-1]) / 2, [np.pi]])
    else:
        cuts = np.linspace(0, np.pi, height + 1)
    area = np.cos(cuts[:-1]) - np.cos(cuts[1:])
    return np.asarray((values * area[:, None, None]).sum(axis=(0, 1)) / values.shape[1])


@pytest.mark.parametrize("height", [10, 64, 200])
@pytest.mark.parametrize("suffix", ["exr", "hdr"])
def test_no_light_is_lost(tmp_path: Path, height: int, suffix: str) -> None:
    values = np.random.default_rng(0).uniform(0, 1, (height, 2 * height, 3)) ** 8
    small = load_map(write(tmp_path / f"room.{suffix}", values), 33.0, 64)
    assert small.shape == (64, 128, 3)
    kept = light_of(small, on_lines=True)
    assert kept == pytest.approx(light_of(values, on_lines=False), rel=0.02)


def test_an_even_map_stays_even_at_the_poles(tmp_path: Path) -> None:
    even = write(tmp_path / "even.exr", np.full((50, 100, 3), 0.25))
    np.testing.assert_allclose(load_map(even, 12.0, 64), 0.25, rtol=1e-6)


@pytest.mark.parametrize(("turned", "column"), [(0, 64), (90, 32), (-90, 96), (180, 0)])
def test_the_map_turns_about_the_vertical(tmp_path: Path, turned: float, column: int) -> None:
    """Column 32 of 128 is φ = π/2, where x > 0: the image's right."""
    values = np.zeros((128, 256, 3))
    values[60:68, 126:130] = 1.0
    small = load_map(write(tmp_path / "lamp.exr", values), turned, 64)[..., 0]
    angle = 2 * np.pi * (np.arange(128) + 0.5) / 128
    middle = np.angle((small.sum(axis=0) * np.exp(1j * angle)).sum()) % (2 * np.pi)
    offset = (middle * 128 / (2 * np.pi) - column + 64) % 128 - 64
    assert offset == pytest.approx(0, abs=1e-3)


def test_one_channel_is_grey(tmp_path: Path) -> None:
    small = load_map(write(tmp_path / "grey.exr", np.full((8, 16, 1), 0.5)), 0.0, 16)
    np.testing.assert_allclose(small, 0.5, rtol=1e-6)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda values: values[:, :-2], "is 14 x 8 px: give one twice as wide as high"),
        (lambda values: np.where(np.arange(16)[:, None] == 3, np.nan, values), "8 pixels that are"),
        (lambda values: values * np.inf, "128 pixels that are NaN or infinite"),
        (lambda values: values - 1.5, "has a value of -0.5: light cannot be negative"),
    ],
    ids=["shape", "nan", "infinite", "negative"],
)
def test_a_broken_map_is_refused(tmp_path: Path, spoil: object, message: str) -> None:
    file = write(tmp_path / "bad.exr", spoil(np.ones((8, 16, 3))))  # type: ignore[operator]
    with pytest.raises(
        InputError, match=f"map .*bad.exr {message}" if "is" in message[:2] else message
    ):
        load_map(file, 0.0, 64)


def test_what_is_no_linear_picture_is_refused(tmp_path: Path) -> None:
    text = tmp_path / "notes.exr"
    text.write_text("no picture")
    with pytest.raises(InputError, match="cannot be read"):
        load_map(text, 0.0, 64)
    png = tmp_path / "photo.png"
    _start().Bitmap(np.zeros((8, 16, 3), np.uint8)).write(str(png))
    with pytest.raises(InputError, match="is no linear RGB image"):
        load_map(png, 0.0, 64)
