import pytest
import torch
from torch.nn import functional as F

from lrsr.sr.tiles import run_in_tiles, spans


def picture(height: int, width: int) -> torch.Tensor:
    return torch.rand(2, 3, height, width, generator=torch.Generator().manual_seed(0))


@pytest.mark.parametrize("size", [(16, 16), (3, 40), (17, 31), (64, 16), (1, 1)], ids=str)
@pytest.mark.parametrize("factor", [1, 2])
def test_tiles_of_a_network_that_sees_one_pixel_are_seamless(
    size: tuple[int, int], factor: int
) -> None:
    def nearest(tile: torch.Tensor) -> torch.Tensor:
        assert tile.shape[-2:] == (16, 12)
        return tile.repeat_interleave(factor, 2).repeat_interleave(factor, 3)

    images = picture(*size)
    larger = run_in_tiles(images, nearest, tile_px=(16, 12), factor=factor)
    wanted = images.repeat_interleave(factor, 2).repeat_interleave(factor, 3)
    assert torch.equal(larger, wanted)


def test_a_network_that_sees_less_than_a_quarter_tile_leaves_no_seam() -> None:
    def blur(tile: torch.Tensor) -> torch.Tensor:
        return F.avg_pool2d(F.pad(tile, (4, 4, 4, 4)), 9, stride=1)

    images = picture(50, 37)
    larger = run_in_tiles(images, blur, tile_px=(16, 16), factor=1)
    torch.testing.assert_close(larger, blur(images), rtol=0, atol=1e-6)


def test_a_picture_of_one_tile_is_one_tile() -> None:
    seen: list[torch.Tensor] = []
    images = picture(8, 8)
    run_in_tiles(images, lambda t: seen.append(t) or t, tile_px=(8, 8), factor=1)
    assert len(seen) == 1
    assert torch.equal(seen[0], images)


def test_what_a_small_picture_lacks_is_its_edge() -> None:
    seen: list[torch.Tensor] = []
    run_in_tiles(picture(2, 3), lambda t: seen.append(t) or t, tile_px=(5, 5), factor=1)
    assert torch.equal(seen[0][..., 1, 3], picture(2, 3)[..., 1, 2])
    assert torch.equal(seen[0][..., 4, 4], picture(2, 3)[..., 1, 2])


def test_tiles_of_one_pixel_do() -> None:
    images = picture(3, 2)
    assert torch.equal(run_in_tiles(images, lambda t: t, tile_px=(1, 1), factor=1), images)


@pytest.mark.parametrize("multiple_of", [1, 4])
@pytest.mark.parametrize("around_px", [0, 3, 50])
@pytest.mark.parametrize("size_px", [1, 15, 16, 17, 61])
def test_every_pixel_is_kept_once_with_all_around_it(
    size_px: int, around_px: int, multiple_of: int
) -> None:
    kept: list[int] = []
    for span in spans(size_px, 16, around_px, multiple_of):
        pixels = range(size_px)[span.kept]
        seen = range(size_px)[span.seen]
        kept += pixels
        around = {max(0, pixels[0] - around_px), min(size_px - 1, pixels[-1] + around_px)}
        assert around <= {*seen}
        assert seen[0] % multiple_of == 0
        assert len(seen) <= 16 + 2 * around_px + 2 * (multiple_of - 1)
        assert [*seen][span.inner(1)] == [*pixels]
        assert span.target(3) == slice(3 * pixels[0], 3 * (pixels[-1] + 1))
    assert kept == [*range(size_px)]
