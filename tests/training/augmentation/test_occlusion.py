import numpy as np
import pytest
import torch

from lrsr.errors import InputError
from lrsr.training.augmentation.occlusion import Occlusion


def hidden(occlusion: Occlusion, rng: np.random.Generator, count: int = 200) -> torch.Tensor:
    """Where faces of no possible colour are hidden: ``(B, 112, 112)``."""
    faces = torch.full((count, 3, 112, 112), -1.0)
    return (occlusion(faces, rng) >= 0).all(dim=1)


@pytest.mark.parametrize("area", [0.02, 0.2, 0.5])
def test_rectangles_have_the_area_asked_for(area: float, rng: np.random.Generator) -> None:
    """Zhong et al.: S_e = area times S; but what is longer than the picture is cut."""
    covered = hidden(Occlusion(1.0, (area, area)), rng).float().mean(dim=(1, 2))
    assert float(covered.median()) == pytest.approx(area, rel=0.03)
    assert float(covered.max()) < area * 1.1


def test_every_part_of_the_face_may_be_hidden(rng: np.random.Generator) -> None:
    counts = hidden(Occlusion(1.0, (0.1, 0.2)), rng, 400).sum(dim=0)
    assert int(counts[5:-5, 5:-5].min()) > 0


def test_bands_leave_the_eyes(rng: np.random.Generator) -> None:
    gone = hidden(Occlusion(1.0, band_share=1.0), rng)
    assert not bool(gone[:, 46:68].any())
    assert bool((gone[:, 0].all(-1) ^ gone[:, -1].all(-1)).all())


def test_the_share_is_that_of_the_hidden(rng: np.random.Generator) -> None:
    share = float(hidden(Occlusion(0.3), rng, 600).flatten(1).any(1).float().mean())
    assert share == pytest.approx(0.3, abs=3 * (0.3 * 0.7 / 600) ** 0.5)


def test_nothing_hidden_nothing_changed(faces: torch.Tensor, rng: np.random.Generator) -> None:
    assert torch.equal(Occlusion()(faces, rng), faces)


def test_more_than_half_of_the_picture_is_refused() -> None:
    with pytest.raises(InputError, match=r"occlusion.area=\[0.1,0.9\]: wanted 0 to 0.5"):
        Occlusion(area=(0.1, 0.9))
