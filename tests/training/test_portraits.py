import numpy as np
import pytest
import torch
from fakes.maps import portraits

from lrsr.errors import InputError
from lrsr.training.augmentation.background import Background
from lrsr.training.augmentation.blur import Blur
from lrsr.training.augmentation.colour import Colour
from lrsr.training.augmentation.misalignment import Misalignment
from lrsr.training.augmentation.occlusion import Occlusion
from lrsr.training.portraits import _mirror

PLACES = [(40, 30), (70, 66)]


def dotted(count: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Crops with two bright dots, and maps of 1 x 2 texels that say where they are."""
    crops = torch.zeros(count, 3, 112, 112, dtype=torch.uint8)
    for x, y in PLACES:
        crops[:, :, y - 2 : y + 3, x - 2 : x + 3] = 255
    x, y = torch.tensor(PLACES).T.float()
    maps = torch.stack([x, y, torch.tensor([3.0, 5.0])])[None, :, None]
    return crops, maps.repeat(count, 1, 1, 1)


def test_a_map_moves_with_its_crop() -> None:
    change = portraits(misalignment=Misalignment(1.0, jitter=0.08))
    faces, maps = change(*dotted(12), np.random.default_rng(0))
    assert (maps - dotted(12)[1]).abs().max() > 5
    rows = torch.arange(112.0)
    for face, (xs, ys, _) in zip(faces[:, 0], maps[:, :, 0], strict=True):
        for x, y in zip(xs, ys, strict=True):
            light = face * ((rows - x).abs() < 8) * ((rows - y).abs() < 8)[:, None]
            centre = (light.sum(0) @ rows, light.sum(1) @ rows)
            assert abs(centre[0] / light.sum() - x) < 0.3
            assert abs(centre[1] / light.sum() - y) < 0.3


def test_nearness_grows_with_the_face() -> None:
    change = portraits(misalignment=Misalignment(0.0, jitter=0.2))
    _, maps = change(*dotted(20), np.random.default_rng(1))
    apart = (maps[:, :2, 0, 0] - maps[:, :2, 0, 1]).norm(dim=1) / np.hypot(30, 36)
    depths = maps[:, 2, 0].sort().values
    np.testing.assert_allclose(depths[:, 0], 3 * apart, rtol=1e-3)
    assert apart.std() > 0.1


def test_half_of_the_faces_are_mirrored_and_texels_change_sides() -> None:
    _, maps = portraits()(*dotted(200), np.random.default_rng(0))
    swapped = maps[:, 2, 0, 0] == 5
    assert 70 < int(swapped.sum()) < 130
    assert (maps[swapped][:, 0, 0] == torch.tensor([41.0, 71.0])).all()
    assert torch.equal(_mirror(_mirror(maps)), maps)


def test_the_same_generator_gives_the_same_portraits() -> None:
    parts = {
        "background": Background(0.5),
        "occlusion": Occlusion(0.5),
        "blur": Blur(0.5, sigma=(0.0, 0.03)),
        "colour": Colour(0.2, 0.1, 0.2, 0.2, 0.2, 8.0, 0.1),
    }
    change = portraits(noise=0.05, misalignment=Misalignment(1.0), **parts)
    one, two = (change(*dotted(4), np.random.default_rng(7)) for _ in range(2))
    assert torch.equal(one[0], two[0])
    assert torch.equal(one[1], two[1])
    assert 0 <= one[0].min() < one[0].max() <= 1


def test_noise_beyond_white_is_refused() -> None:
    with pytest.raises(InputError, match=r"degradation\.noise=2: wanted 0 to 1"):
        portraits(noise=2.0)
