from pathlib import Path

import cv2
import numpy as np
import pytest
import torch

from lrsr.errors import ImageContractError
from lrsr.experiments.contact_sheet import GAP_PX, HEADING_PX, TILE_PX, write_contact_sheet


def test_every_picture_has_its_place(tmp_path: Path) -> None:
    shades = torch.tensor([0.2, 0.6])[:, None, None, None]
    pictures = {"Probe": shades.expand(2, 3, 8, 8), "Reference": 1 - shades.expand(2, 3, 32, 32)}
    sheet = cv2.imread(str(write_contact_sheet(tmp_path / "sheet.png", pictures)))
    step = TILE_PX + GAP_PX
    assert sheet.shape == (HEADING_PX + 2 * step + GAP_PX, 2 * step + GAP_PX, 3)
    middles = [GAP_PX + TILE_PX // 2 + number * step for number in (0, 1)]
    found = sheet[np.ix_([HEADING_PX + y for y in middles], middles)][..., 0]
    assert found.tolist() == [[51, 204], [153, 102]]


def test_a_small_picture_keeps_its_square_pixels(tmp_path: Path) -> None:
    chequer = torch.tensor([[0.0, 1.0], [1.0, 0.0]]).expand(1, 3, 2, 2)
    sheet = cv2.imread(str(write_contact_sheet(tmp_path / "s.png", {"a": chequer, "b": chequer})))
    tile = sheet[HEADING_PX + GAP_PX :, GAP_PX:][:TILE_PX, :TILE_PX, 0]
    expected = np.kron([[0, 255], [255, 0]], np.ones((TILE_PX // 2, TILE_PX // 2)))
    np.testing.assert_array_equal(tile, expected)


@pytest.mark.parametrize(("columns", "people"), [(1, 1), (2, 7), (3, 2), (5, 3), (6, 5), (7, 1)])
def test_the_sheet_is_as_large_as_its_pictures(tmp_path: Path, columns: int, people: int) -> None:
    # At 100 dpi, matplotlib 3.9 makes 28 of 29 px, 57 of 58, 114 of 115.
    white = torch.ones(1, 1, 1, 1).expand(people, 3, 4, 4)
    pictures = {f"method {number}": white for number in range(columns)}
    sheet = cv2.imread(str(write_contact_sheet(tmp_path / "sheet.png", pictures)))
    step = TILE_PX + GAP_PX
    assert sheet.shape == (HEADING_PX + people * step + GAP_PX, columns * step + GAP_PX, 3)


def test_columns_must_show_the_same_people(tmp_path: Path) -> None:
    with pytest.raises(ImageContractError, match="as many people"):
        write_contact_sheet(
            tmp_path / "sheet.png", {"a": torch.zeros(1, 3, 4, 4), "b": torch.zeros(2, 3, 4, 4)}
        )
    assert not (tmp_path / "sheet.png").exists()
