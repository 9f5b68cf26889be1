import numpy as np
import pytest
import torch

from lrsr.errors import InputError
from lrsr.images import resize_bicubic
from lrsr.recognition.detection.enlargement import Enlargement


def ramp(height: int, width: int) -> torch.Tensor:
    """Red is x / 1000, green is y / 1000."""
    y, x = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    return torch.stack([x / 1000, y / 1000, torch.zeros_like(x)])[None].float()


@pytest.mark.parametrize(
    ("size", "ipd_px", "factor"),
    [
        ((32, 32), None, 8),
        ((100, 75), None, 4),
        ((256, 300), None, 1),
        ((1080, 1920), None, 1),
        ((1080, 1920), 8, 2),  # a border of 32 px, not of 480: three times 1984 is beyond 4096
        ((480, 640), 8, 5),
        ((480, 640), 60, 1),
        ((4000, 3000), None, 0.5),
    ],
)
def test_small_pictures_are_enlarged_and_huge_ones_shrunk(
    size: tuple[int, int], ipd_px: float | None, factor: float
) -> None:
    assert Enlargement().factor(*size, ipd_px) == factor


@pytest.mark.parametrize(
    "rule",
    [
        Enlargement(border=0.25, shorter_px=80),
        Enlargement(border=0, shorter_px=1),
        Enlargement(border=0.3, shorter_px=1, longest_px=64),
    ],
    ids=["larger", "as it is", "smaller"],
)
def test_a_point_comes_back_to_where_it_was(rule: Enlargement) -> None:
    """The colours of the ramp say where each pixel of the enlarged picture comes from."""
    large, back = rule(ramp(50, 70), multiple_px=8)
    assert [size % 8 for size in large.shape[-2:]] == [0, 0]
    height, width = large.shape[-2:]
    inner = np.array([[width * x // 10, height * y // 10] for x in (4, 5, 6) for y in (4, 5, 6)])
    there = [large[0, :2, y, x].numpy() * 1000 for x, y in inner]
    np.testing.assert_allclose(back(inner.astype(np.float32)), there, atol=1e-3)


def test_where_faces_are_known_to_be_small_a_border_holds_one() -> None:
    large, back = Enlargement(ipd_px=16, longest_px=4096)(ramp(100, 300), ipd_px=8)
    assert tuple(large.shape[-2:]) == (2 * (100 + 2 * 25), 2 * (300 + 2 * 32))
    assert (back.left_px, back.top_px) == (32, 25)


def test_the_border_repeats_the_edge_and_the_rest_is_our_bicubic() -> None:
    picture = torch.rand(2, 3, 8, 12, generator=torch.Generator().manual_seed(0))
    padded = torch.nn.functional.pad(picture, (3, 3, 2, 2), mode="replicate")
    large, _ = Enlargement(border=0.25, shorter_px=16)(picture)
    torch.testing.assert_close(large, resize_bicubic(padded, 2).clamp(0, 1))


@pytest.mark.parametrize(
    ("field", "value", "says"),
    [
        ("border", -0.1, "at least 0"),
        ("border", 3, "at most 2"),
        ("shorter_px", 0, "at least 1"),
        ("ipd_px", 0, "at least 1"),
        ("longest_px", 10, "at least 64"),
    ],
)
def test_a_number_out_of_range_is_refused(field: str, value: float, says: str) -> None:
    with pytest.raises(InputError, match=rf"recognition\.enlargement\.{field}={value}.*{says}"):
        Enlargement(**{field: value})
