import io
from typing import Any

import cv2
import numpy as np
import pytest
import torch
from matplotlib.image import imread
from numpy.typing import NDArray

from lrsr.errors import ImageContractError
from lrsr.experiments.report.sheets import (
    _GAP_PX,
    _HEADING_PX,
    _LINE_PX,
    _TILE_PX,
    draw_contact_sheet,
    draw_portraits,
)


def test_every_picture_has_its_place() -> None:
    shades = torch.tensor([0.2, 0.6])[:, None, None, None]
    pictures = {"Probe": shades.expand(2, 3, 8, 8), "Reference": 1 - shades.expand(2, 3, 32, 32)}
    sheet = cv2.imdecode(np.frombuffer(draw_contact_sheet(pictures), np.uint8), cv2.IMREAD_COLOR)
    step = _TILE_PX + _GAP_PX
    assert sheet.shape == (_HEADING_PX + 2 * step + _GAP_PX, 2 * step + _GAP_PX, 3)
    middles = [_GAP_PX + _TILE_PX // 2 + number * step for number in (0, 1)]
    found = sheet[np.ix_([_HEADING_PX + y for y in middles], middles)][..., 0]
    assert found.tolist() == [[51, 204], [153, 102]]


def test_a_small_picture_keeps_its_square_pixels() -> None:
    chequer = torch.tensor([[0.0, 1.0], [1.0, 0.0]]).expand(1, 3, 2, 2)
    sheet = cv2.imdecode(
        np.frombuffer(draw_contact_sheet({"a": chequer, "b": chequer}), np.uint8), cv2.IMREAD_COLOR
    )
    tile = sheet[_HEADING_PX + _GAP_PX :, _GAP_PX:][:_TILE_PX, :_TILE_PX, 0]
    expected = np.kron([[0, 255], [255, 0]], np.ones((_TILE_PX // 2, _TILE_PX // 2)))
    np.testing.assert_array_equal(tile, expected)


@pytest.mark.parametrize(("columns", "people"), [(1, 1), (2, 7), (3, 2), (5, 3), (6, 5), (7, 1)])
def test_the_sheet_is_as_large_as_its_pictures(columns: int, people: int) -> None:
    # At 100 dpi, matplotlib 3.9 makes 28 of 29 px, 57 of 58, 114 of 115.
    white = torch.ones(1, 1, 1, 1).expand(people, 3, 4, 4)
    pictures = {f"method {number}": white for number in range(columns)}
    sheet = cv2.imdecode(np.frombuffer(draw_contact_sheet(pictures), np.uint8), cv2.IMREAD_COLOR)
    step = _TILE_PX + _GAP_PX
    assert sheet.shape == (_HEADING_PX + people * step + _GAP_PX, columns * step + _GAP_PX, 3)


@pytest.mark.parametrize(
    "long", ["Mean of embeddings + Bicubic 4, 4 frames", "lighting side\ncompression heavy"]
)
def test_a_long_heading_stays_above_its_column(long: str) -> None:
    black = torch.zeros(1, 3, 4, 4)
    png = draw_contact_sheet({"": black, long: black, " ": black})
    sheet = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_GRAYSCALE)
    top = len(sheet) - 2 * _GAP_PX - _TILE_PX
    columns = np.flatnonzero((sheet[:top] < 128).any(axis=0))
    assert _TILE_PX + 2 * _GAP_PX <= columns.min() < columns.max() < 2 * (_TILE_PX + _GAP_PX)


@pytest.mark.parametrize("long", ["image_of_somebody_2024_05.jpg", "lighting side, compression"])
def test_a_long_name_stays_left_of_its_row(long: str) -> None:
    black = torch.zeros(2, 3, 4, 4)
    png = draw_contact_sheet({"a": black}, [long, ""])
    sheet = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_GRAYSCALE)
    left = sheet[:, : _GAP_PX + _TILE_PX]
    assert (left < 128).any()
    assert (left[:, 0] == 255).all()
    assert (left[:, -1] == 255).all()


def test_columns_must_show_the_same_people() -> None:
    with pytest.raises(ImageContractError, match="as many people"):
        draw_contact_sheet({"a": torch.zeros(1, 3, 4, 4), "b": torch.zeros(2, 3, 4, 4)})


def drawn(faces: Any, *, columns: int = 3, **options: Any) -> NDArray[np.int_]:
    captions = options.pop("captions", [f"person {k}" for k in range(len(faces))])
    png = draw_portraits(faces, captions, columns=columns, **options)
    return np.rint(imread(io.BytesIO(png))[..., :3] * 255).astype(int)


def faces(count: int, height: int = 24, width: int = 20) -> NDArray[np.float64]:
    return np.random.default_rng(0).integers(0, 256, (count, 3, height, width)) / 255


def levels(face: NDArray[np.float64]) -> NDArray[np.int_]:
    return np.rint(face * 255).astype(int).transpose(1, 2, 0)


def test_every_face_is_there_pixel_for_pixel_row_by_row() -> None:
    shown = faces(5)
    sheet = drawn(shown, columns=3)
    for number, face in enumerate(shown):
        row, column = divmod(number, 3)
        y, x = _GAP_PX + row * (24 + _LINE_PX + _GAP_PX), _GAP_PX + column * (20 + _GAP_PX)
        np.testing.assert_array_equal(sheet[y : y + 24, x : x + 20], levels(face))


@pytest.mark.parametrize(
    ("width", "columns"), [(20, 3), (25, 4), (50, 2), (53, 2), (107, 1), (21, 1), (64, 10)]
)
def test_the_sheet_is_as_large_as_its_portraits(width: int, columns: int) -> None:
    # At 100 dpi, matplotlib 3.9 makes 28 of 29 px, 57 of 58, 114 of 115.
    sheet = drawn(faces(2 * columns, 25, width), columns=columns)
    assert sheet.shape[0] == _GAP_PX + 2 * (25 + _LINE_PX + _GAP_PX) - _GAP_PX
    assert sheet.shape[1] == _GAP_PX + columns * (width + _GAP_PX)


def test_few_portraits_make_a_narrow_sheet() -> None:
    assert drawn(faces(2), columns=10).shape == drawn(faces(2), columns=2).shape


def test_a_row_that_is_not_full_is_white_at_its_end() -> None:
    sheet = drawn(faces(4), columns=3)
    assert (sheet[_GAP_PX + 24 + _LINE_PX :, _GAP_PX + 20 + 20 :] == 255).all()


def test_there_is_a_line_under_each_face() -> None:
    sheet = drawn(faces(3, 24, 80), columns=3, captions=["one", "", "three"])
    below = sheet[_GAP_PX + 24 : _GAP_PX + 24 + _LINE_PX]
    dark = [(below[:, _GAP_PX + k * (80 + _GAP_PX) :][:, :80] < 128).any() for k in range(3)]
    assert dark == [True, False, True]


def test_a_pairs_faces_are_nearer_to_each_other_than_to_the_next_pair() -> None:
    shown = faces(4)
    sheet = drawn(shown, columns=4, group=2, captions=[""] * 4)
    dark = np.flatnonzero((sheet < 255).all(axis=2).any(axis=0))
    gaps = np.diff(dark)[np.diff(dark) > 1] - 1
    assert gaps.tolist() == [_GAP_PX, 5 * _GAP_PX, _GAP_PX]


def test_what_lies_outside_the_range_is_clipped_for_the_picture() -> None:
    face = np.stack([np.full((4, 4), value) for value in (-0.5, 0.5, 1.5)])
    assert drawn([face])[_GAP_PX, _GAP_PX].tolist() == [0, 128, 255]


def test_the_same_portraits_are_the_same_bytes() -> None:
    first, again = (draw_portraits(faces(3), ["a", "b", "c"], columns=2) for _ in range(2))
    assert first == again


@pytest.mark.parametrize(
    "wrong",
    [[], [np.zeros((3, 4, 4)), np.zeros((3, 4, 5))], [np.zeros((1, 4, 4))], [np.zeros((4, 4))]],
    ids=["nobody", "two sizes", "grey", "no channels"],
)
def test_what_is_no_row_of_faces_is_refused(wrong: list[NDArray[np.float64]]) -> None:
    with pytest.raises(ImageContractError, match=r"portraits: got shapes .*wanted one \(3, h, w\)"):
        drawn(wrong)


def test_a_missing_caption_is_noticed() -> None:
    with pytest.raises(ImageContractError, match="got 1 captions, 2 faces"):
        drawn(faces(2), captions=["one"])
