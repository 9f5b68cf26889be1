"""Interpolation along edges, against another implementation and against straight edges."""

import json
from pathlib import Path

import pytest
import torch

from lrsr.camera.bayer import PATTERNS, mosaic
from lrsr.camera.demosaic import METHODS, demosaic
from lrsr.camera.edge_aware import interpolate_along_edges
from lrsr.errors import InputError

pytestmark = pytest.mark.usefixtures("one_thread")

CASES = json.loads((Path(__file__).parents[1] / "data" / "menon2007.json").read_text())["cases"]
RANDOM = torch.Generator().manual_seed(0)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["pattern"])
def test_it_is_menons_method_as_another_package_has_it(case: dict[str, list[list[float]]]) -> None:
    # Values of colour-demosaicing, frozen; the file says how. Borders: of the mirrored mosaic.
    raw = torch.tensor(case["raw"], dtype=torch.float64)[None, None]
    theirs = torch.tensor(case["rgb"], dtype=torch.float64)
    ours = interpolate_along_edges(raw, case["pattern"])[0]
    assert float((ours - theirs).abs().max()) <= 5.1e-5  # the file's digits, of 255


def stripes(axis: int, side: int = 11) -> torch.Tensor:
    """Random levels that are the same all along rows or columns, ``(side, side)``, whole."""
    levels = torch.randint(0, 256, (side,), generator=RANDOM).float()
    return levels.expand(side, side) if axis == 1 else levels[:, None].expand(side, side)


@pytest.mark.parametrize("axis", [0, 1], ids=["rows", "columns"])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_grey_edges_along_rows_or_columns_come_back_exactly(pattern: str, axis: int) -> None:
    image = stripes(axis).expand(1, 3, 11, 11)
    raw = mosaic(image, pattern)
    assert float((interpolate_along_edges(raw, pattern) - image).abs().max()) < 1e-4
    assert all(float((demosaic(raw, pattern, m) - image).abs().max()) > 20 for m in METHODS[:2])


@pytest.mark.parametrize("axis", [0, 1], ids=["rows", "columns"])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_coloured_edges_along_rows_or_columns_keep_their_green(pattern: str, axis: int) -> None:
    image = torch.stack([stripes(axis) for _ in range(3)])[None]
    green = interpolate_along_edges(mosaic(image, pattern), pattern)[:, 1]
    assert torch.allclose(green, image[:, 1], atol=1e-4)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_rows_and_columns_are_treated_alike(pattern: str) -> None:
    image = torch.rand(2, 3, 14, 14, generator=RANDOM, dtype=torch.float64)
    turned_pattern = pattern[0] + pattern[2] + pattern[1] + pattern[3]
    turned = interpolate_along_edges(mosaic(image.mT, turned_pattern), turned_pattern)
    assert torch.allclose(turned.mT, interpolate_along_edges(mosaic(image, pattern), pattern))


@pytest.mark.parametrize("slope", [0.1, 0.2])
def test_steep_edges_have_less_zipper_and_false_colour(slope: float) -> None:
    # A grey edge some degrees off the columns. Zipper: what alternates down a column; false colour:
    # how far red and blue lie from green. Measured a fifteenth to a third of Malvar's zipper; on
    # diagonals, which no direction here follows, there is no gain.
    x, y = torch.meshgrid(torch.arange(48.0), torch.arange(48.0), indexing="xy")
    edge = torch.sigmoid(2 * (x - 24 + slope * (y - 24))).expand(1, 3, 48, 48)
    zipper, colour = {}, {}
    for method in METHODS:
        picture = demosaic(mosaic(edge), method=method)[..., 4:-4, 4:-4]
        miss = (picture - edge[..., 4:-4, 4:-4]).mean(1)
        zipper[method] = float(miss.diff(n=2, dim=1).square().mean().sqrt())
        colour[method] = float((picture - picture[:, 1:2]).square().mean().sqrt())
    assert zipper["edge_aware"] < 0.33 * min(zipper["malvar"], zipper["bilinear"])
    assert colour["edge_aware"] < 0.2 * min(colour["malvar"], colour["bilinear"])


def test_a_tie_has_the_gradient_of_rows() -> None:
    # A flat field is as smooth along rows as along columns: green at a photosite of red comes from
    # the row, and the column has no part in it.
    raw = torch.full((1, 1, 9, 9), 0.5, requires_grad=True)
    interpolate_along_edges(raw, "RGGB")[0, 1, 4, 4].backward()
    assert raw.grad is not None
    assert float(raw.grad.sum()) == pytest.approx(1.0)
    assert float(raw.grad[0, 0, 4].sum()) == pytest.approx(1.0)


def test_an_unknown_pattern_is_refused() -> None:
    with pytest.raises(InputError, match="pattern=XXXX"):
        interpolate_along_edges(torch.zeros(1, 1, 4, 4), "XXXX")
