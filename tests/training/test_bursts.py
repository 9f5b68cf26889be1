"""Bursts that are rendered or moved, what is cut from them, and what learns from that."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.maker import FakeMaker
from lightning.pytorch import Trainer

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.evaluation.quality import psnr_y
from lrsr.identities.person import Person
from lrsr.identities.roster import IdentityRange
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.picture import stack
from lrsr.pictures.render import take_pictures
from lrsr.pictures.sitting import Sitting
from lrsr.presets import preset
from lrsr.rendering.lens import PINHOLE
from lrsr.rendering.scene import Film, Quality
from lrsr.rendering.standpoint import LEVEL
from lrsr.sr import Correlation, load_fusion
from lrsr.sr.fusion import Mean
from lrsr.sr.onnx_network import Onnx
from lrsr.training import restoration
from lrsr.training.burst_restoration import BurstRestoration
from lrsr.training.bursts import Bursts, LaidOver
from lrsr.training.patches import RgbPatches
from lrsr.training.restoration import Restoration
from lrsr.training.run import train
from lrsr.training.shrinking.clean import Clean
from lrsr.training.shrinking.one_camera import OneCamera

VIDEO = preset("burst", "video")


def module(cache: RenderCache, maker: FakeMaker, count: int = 1, **settings: Any) -> Bursts:
    given: dict[str, Any] = {
        "people": [Person("train", index) for index in range(count)],
        "validation_people": [Person("validation", 0)],
        "poses": [preset("pose", "frontal")],
        "lightings": [preset("lighting", "frontal")],
        "ipd_px": [8.0],
        "degradation": Clean(),
        "views": 1,
        "scale": 2,
        "patches": LaidOver(Correlation(), 16),
        "lens": PINHOLE,
        "standpoint": LEVEL,
        "quality": Quality(),
        "camera": Camera(),
        "batch_size": 1,
        "seed": 0,
        "progress": False,
        "burst": VIDEO,
        "frames": 4,
        "moved": True,
        **settings,
    }
    return Bursts(cache=cache, maker=maker, **given)


def test_rendered_frames_are_those_of_an_evaluation(cache: RenderCache, maker: FakeMaker) -> None:
    data = module(cache, maker, 2, moved=False)
    people, scene = IdentityRange(split="train", count=2), data.conditions[0][0]
    sitting = Sitting(people, scene, Film(8.0), data.quality, burst=VIDEO)
    told = [sitting.recipe(p, 2, number) for p in people.people() for number in range(4)]
    assert data.recipes(data.people, 2) == told


def test_rendered_bursts_show_the_middle_and_the_target_is_the_first_frame(
    cache: RenderCache, maker: FakeMaker
) -> None:
    data = module(cache, maker, 2, moved=False)
    fine, _ = stack(take_pictures(data.recipes(data.people, 2), cache, Camera(), maker=maker))
    small, true = (torch.cat(parts) for parts in zip(*data.pairs(0), strict=True))
    assert (small.shape, true.shape) == ((2, 4, 3, 16, 16), (2, 3, 32, 32))
    torch.testing.assert_close(true, fine[::4, :, 16:48, 16:48], atol=1 / 255, rtol=0)


def test_moved_frames_have_moved_as_the_burst_says(cache: RenderCache, maker: FakeMaker) -> None:
    data = module(cache, maker, patches=LaidOver(Correlation(), 32))
    ((small, true),) = data.pairs(0)
    ((again, _),) = data.pairs(0)
    ((other, same),) = data.pairs(1)
    assert torch.equal(small, again)
    assert torch.equal(true, same)
    assert torch.equal(small[:, 0], other[:, 0])
    assert not torch.equal(small[:, 1], other[:, 1])
    rng = np.random.default_rng([data.degradation_seeds(0, 0, 1)[0], 2])
    shifts = rng.uniform(-1, 1, (4, 4))[1:, :2] * 0.12 * 8
    middle = torch.tensor([15.5, 15.5, 1.0])
    found = Correlation(motion="affine")(small)[0, 1:] @ middle - middle[:2]
    np.testing.assert_allclose(found, shifts, atol=0.1)


def test_every_compression_of_the_camera_is_a_burst(cache: RenderCache, maker: FakeMaker) -> None:
    data = module(cache, maker, degradation=OneCamera(["none", "heavy"]))
    ((small, true),) = data.pairs(0)
    assert (small.shape, true.shape) == ((2, 4, 3, 16, 16), (2, 3, 32, 32))
    assert torch.equal(true[0], true[1])
    assert not torch.equal(small[0], small[1])
    assert {camera.stored for _, camera in data.shots()} == {None}


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"frames": 0}, "data.frames=0: wanted at least 1"),
        ({"frames": 3, "moved": False}, "data.frames=3: wanted at least 1, and a divisor of 64"),
        ({"patches": RgbPatches(16, 8)}, "data.patches=RgbPatches: wanted patches=laid_over"),
        ({"patches": LaidOver(Correlation(), 64)}, "data.ipd_px=8.0: wanted pictures at least 64"),
    ],
    ids=["none", "divisor", "patches", "wide"],
)
def test_what_makes_no_bursts_is_refused(
    cache: RenderCache, maker: FakeMaker, wrong: dict[str, Any], says: str
) -> None:
    with pytest.raises(InputError, match=says):
        module(cache, maker, **wrong)


def test_frames_are_laid_over_for_bursts_alone() -> None:
    with pytest.raises(InputError, match=r"data.patches.frame_px=4: wanted at least 8"):
        LaidOver(Correlation(), 4)
    with pytest.raises(InputError, match="takes bursts: give data=bursts"):
        LaidOver(Correlation()).cut(torch.zeros(1, 3, 8, 8), torch.zeros(1, 3, 16, 16))


def fusing(**settings: Any) -> BurstRestoration:
    given: dict[str, Any] = {
        "architecture": "fusion",
        "arguments": {"scale": 2, "features": 4},
        "scale": 2,
        "loss": "l1",
        "optimizer": partial(torch.optim.Adam, lr=1e-3),
    }
    return BurstRestoration(**{**given, **settings})


def test_a_step_shows_any_number_of_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []
    network = fusing()
    network.network.forward = lambda laid: seen.append(laid.shape[1]) or torch.zeros(1, 3, 16, 16)
    for step in range(30):
        monkeypatch.setattr(Restoration, "global_step", step)
        network.loss((torch.ones(1, 5, 16, 8, 8), torch.zeros(1, 3, 16, 16)))
    assert {*seen} == {1, 2, 3, 4, 5}


def test_networks_of_bursts_and_of_pictures_learn_apart() -> None:
    with pytest.raises(InputError, match="architecture=edsr: wanted a network of burst"):
        fusing(architecture="edsr", arguments={"blocks": 1, "features": 4})
    optimizer = partial(torch.optim.Adam, lr=1.0)
    with pytest.raises(InputError, match="architecture=fusion: wanted a network of luminance or"):
        Restoration(architecture="fusion", scale=4, loss="l1", optimizer=optimizer)


def learned(data: Bursts, folder: Path, epochs: int) -> BurstRestoration:
    learner = fusing()
    quiet = partial(Trainer, accelerator="cpu", devices=1, max_epochs=epochs, precision="32-true")
    train(learner, data, folder=folder, trainer=quiet, depends_on={})
    return learner


@pytest.mark.usefixtures("_no_export")
def test_a_resumed_run_ends_where_the_straight_one_does(
    cache: RenderCache, maker: FakeMaker, tmp_path: Path
) -> None:
    straight = learned(module(cache, maker), tmp_path / "straight", 2)
    learned(module(cache, maker), tmp_path / "cut", 1)
    resumed = learned(module(cache, maker), tmp_path / "cut", 2)
    assert straight.history == resumed.history
    for name, value in straight.state_dict().items():
        torch.testing.assert_close(resumed.state_dict()[name], value, rtol=0, atol=0, msg=name)
    figures = straight.history[-1]
    ((burst, true),) = module(cache, maker).pairs(None)
    shipped = load_fusion(tmp_path / "straight" / "model.safetensors")
    for name, fused in (("", shipped(burst)), ("mean_", Mean(2)(burst))):
        psnr_db = psnr_y(fused.numpy(), true.numpy(), shave=2)
        assert figures[f"val/{name}psnr_y_db"] == pytest.approx(float(psnr_db[0]), abs=1e-4)


@pytest.mark.slow  # ten seconds in torch's exporter
def test_its_onnx_file_is_for_bursts(cache: RenderCache, maker: FakeMaker, tmp_path: Path) -> None:
    learned(module(cache, maker), tmp_path, 1)
    with pytest.raises(InputError, match=r"model.onnx"):
        Onnx(tmp_path / "model.onnx")


@pytest.fixture
def _no_export(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(restoration, "export_onnx", lambda *_, **__: 0.0)
