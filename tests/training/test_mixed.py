"""People and pictures, each a share of every epoch."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.lessons import draw_pictures
from fakes.maker import FakeMaker

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.identities.person import Person
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.image_files import write_png
from lrsr.presets import preset
from lrsr.rendering.lens import PINHOLE
from lrsr.rendering.scene import Quality
from lrsr.rendering.standpoint import LEVEL
from lrsr.training.images import Images
from lrsr.training.mixed import Mixed
from lrsr.training.pairs import Pairs
from lrsr.training.patches import LuminancePatches
from lrsr.training.shrinking.one_camera import OneCamera


@pytest.fixture
def mixed(tmp_path: Path, cache: RenderCache, maker: FakeMaker) -> Any:
    for number, picture in enumerate(draw_pictures(5, 48, seed=1)):
        write_png(tmp_path / "pictures" / f"{number}.png", picture)
    both: dict[str, Any] = {
        "scale": 2,
        "degradation": OneCamera(),
        "camera": Camera(),
        "patches": LuminancePatches(),
        "batch_size": 8,
        "seed": 0,
    }

    def make(share: float, **more: Any) -> Mixed:
        rendered = Pairs(
            people=[Person("train", index) for index in range(6)],
            validation_people=[Person("validation", 0)],
            poses=[preset("pose", "frontal")],
            lightings=[preset("lighting", "frontal")],
            ipd_px=[8.0],
            views=1,
            lens=PINHOLE,
            standpoint=LEVEL,
            quality=Quality(),
            cache=cache,
            maker=maker,
            progress=False,
            **both,
        )
        images = Images(root=tmp_path / "pictures", **{**both, **more})
        return Mixed(rendered=rendered, images=images, rendered_share=share)

    return make


def ready(data: Mixed) -> Mixed:
    data.prepare_data()
    data.setup("fit")
    return data


@pytest.mark.parametrize(
    ("share", "people", "pictures"),
    [(0.5, 16, 16), (0.9, 54, 6), (0.2, 4, 16)],
)
def test_an_epoch_has_the_share_and_all_of_what_there_is_less_of(
    mixed: Any, share: float, people: int, pictures: int
) -> None:
    """54 patches of people, 4 x 4 of pictures."""
    data = ready(mixed(share))
    rows = data.rows(np.random.default_rng(0))
    assert (int((rows < 54).sum()), int((rows >= 54).sum())) == (people, pictures)
    assert len(set(rows.tolist())) == len(rows)
    other = data.rows(np.random.default_rng(1))
    assert len(other) == len(rows)
    assert {*other.tolist()} != {*rows.tolist()}


def test_patches_are_those_of_both_and_so_are_the_validation_pictures(mixed: Any) -> None:
    data = ready(mixed(0.5))
    inputs, _ = data.cut(0)
    assert torch.equal(inputs, torch.cat([part.cut(0)[0] for part in (data.rendered, data.images)]))
    assert [true.shape[-1] for _, true in data.val_dataloader()] == [64, 48]
    assert sum(len(targets) for _, targets in data.train_dataloader()) == 32


def test_what_it_depends_on_and_its_card_are_those_of_both(mixed: Any) -> None:
    data = mixed(0.5)
    assert {"people", "renderings", "pictures", "files"} <= {*data.about()}
    assert "no down-sampling; or the linear light of pictures" in data.lr_made_by
    assert data.unread == {}
    assert not ready(data).redrawn


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_a_share_of_all_or_nothing_is_refused(mixed: Any, share: float) -> None:
    with pytest.raises(InputError, match=f"data.rendered_share={share}: wanted a number > 0"):
        mixed(share)
