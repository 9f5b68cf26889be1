"""Recordings: frame types, macroblocks, rates, and the stand-in's distance."""

import numpy as np
import pytest
import torch

from lrsr.camera.codec import jpeg_differentiable
from lrsr.camera.video import _STAND_IN, Video, _play
from lrsr.errors import ImageContractError, InputError
from lrsr.images import linear_to_srgb, resize_bicubic


def recordings(
    batch: int = 2, frames: int = 3, side: int = 32, noise: float = 0.01
) -> torch.Tensor:
    """Smooth skin-like images ``(T, B, 3, side, side)`` with noise of its own in each frame."""
    generator = torch.Generator().manual_seed(0)
    luma = 0.3 + 0.4 * torch.rand(batch, 1, side // 8, side // 8, generator=generator)
    colours = luma + 0.1 * torch.rand(batch, 3, side // 8, side // 8, generator=generator)
    still = resize_bicubic(colours, 8).expand(frames, batch, 3, side, side)
    moving = still + noise * torch.randn(still.shape, generator=generator)
    return (moving.clamp(0, 1) * 255).round() / 255


def as_bytes(frames: torch.Tensor) -> np.ndarray:
    return frames.mul(255).round().byte().permute(0, 2, 3, 1).contiguous().numpy()


def psnr_db(a: torch.Tensor, b: torch.Tensor) -> float:
    return float(-10 * torch.log10((a - b).square().mean()))


def test_the_last_frame_of_h264_is_predicted_and_small() -> None:
    recording = Video("h264", frames=3).record(as_bytes(recordings(1)[:, 0]))
    assert [kind for _, kind in _play(recording, "h264")] == ["I", "P", "P"]
    assert len(recording[2]) < 0.5 * len(recording[0])


def test_every_frame_of_motion_jpeg_stands_alone() -> None:
    recording = Video("mjpeg", crf=8).record(as_bytes(recordings(1)[:, 0]))
    assert [kind for _, kind in _play(recording, "mjpeg")] == ["I", "I", "I"]


@pytest.mark.parametrize(("codec", "crf"), [("h264", 28), ("mjpeg", 8)])
def test_the_face_comes_back_where_it_was(codec: str, crf: int) -> None:
    frames = recordings(noise=0.0)
    played = Video(codec, crf=crf)(frames, origin_px=(5, 11))
    assert played.shape == frames.shape[1:]
    assert torch.allclose(played * 255, (played * 255).round(), atol=1e-4)
    assert psnr_db(played, frames[-1]) > 32
    assert psnr_db(played.roll(1, -1), frames[-1]) < psnr_db(played, frames[-1]) - 3


def test_a_larger_rate_factor_loses_more_and_writes_less() -> None:
    frames = recordings(1, noise=0.0)
    loss, size = [], []
    for crf in (15, 28, 40):
        video = Video(crf=crf)
        loss.append(psnr_db(video(frames), frames[-1]))
        size.append(sum(map(len, video.record(as_bytes(frames[:, 0])))))
    assert loss == sorted(loss, reverse=True)
    assert size == sorted(size, reverse=True)


def test_a_bit_rate_rules_where_it_is_given() -> None:
    frames = as_bytes(recordings(1, side=64, noise=0.05)[:, 0])
    poor, rich = (sum(map(len, Video(bit_rate_kbps=k).record(frames))) for k in (50, 2000))
    assert poor < 0.5 * rich


def test_edges_of_macroblocks_lie_on_the_grid_of_the_frame() -> None:
    # A strongly quantised ramp steps between blocks: 4 x 4 transforms, on the frame's grid.
    ramp = (0.2 + 0.01 * torch.arange(48.0)).expand(1, 1, 3, 48, 48)
    for x in (0, 1, 6):
        video = Video(crf=51, frames=1, surround="edge", speed="ultrafast")
        steps = video(ramp, origin_px=(x, 0))[0].mean((0, 1)).diff().abs()
        strongest = (steps[4:-4].topk(3).indices + 4 + 1 + x) % 4
        assert strongest.tolist() == [0, 0, 0]


def test_the_same_frames_give_the_same_picture_whatever_their_batch() -> None:
    frames, video = recordings(3), Video()
    together = video(frames)
    assert torch.equal(together, video(frames))
    assert torch.equal(together[1:2], video(frames[:, 1:2]))


def test_what_surrounds_the_face_may_be_grey_or_its_edge() -> None:
    frames = recordings(1, noise=0.0)
    grey, edge = (Video(crf=35, surround=what)(frames) for what in ("grey", "edge"))
    assert psnr_db(grey, edge) < 45


@pytest.mark.parametrize(("codec", "chroma"), [("h264", "4:2:0"), ("mjpeg", "4:2:2")])
def test_the_stand_in_is_a_jpeg_of_the_codecs_sampling(codec: str, chroma: str) -> None:
    video, frames = Video(codec, crf=30), recordings(1)
    soft = video(frames, origin_px=(3, 5), differentiable=True)
    quality = video.stand_in_quality
    alike = jpeg_differentiable(frames[-1], quality, chroma=chroma, origin_px=(3, 5))
    assert torch.equal(soft, alike)


@pytest.mark.parametrize(
    ("codec", "crf"), [(codec, crf) for codec, table in _STAND_IN.items() for crf in table]
)
def test_the_stand_in_loses_as_much_of_faces_and_is_as_far_as_it_says(
    faces: torch.Tensor, codec: str, crf: int
) -> None:
    # Measured within 0.4 dB of equal loss; H.264 as far from its stand-in as from the original.
    still = (linear_to_srgb(faces) * 255).round() / 255
    video, frames = Video(codec, crf=crf), still.expand(3, -1, -1, -1, -1)
    true, soft = video(frames), video(frames, differentiable=True)
    loss = psnr_db(true, still)
    assert psnr_db(soft, still) == pytest.approx(loss, abs=0.5)
    assert loss - 0.5 < psnr_db(soft, true) < loss + 3


def test_only_the_stand_in_has_a_gradient() -> None:
    frames = recordings(1).requires_grad_()
    assert not Video()(frames.detach()).requires_grad
    Video()(frames, differentiable=True).square().sum().backward()
    assert frames.grad is not None
    assert float(frames.grad[-1].abs().mean()) > 0.05
    assert float(frames.grad[:-1].abs().max()) == 0


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ({"codec": "h266"}, "codec=h266: wanted one of h264, mjpeg"),
        ({"crf": 52}, r"crf=52: wanted 0\.\.51"),
        ({"codec": "mjpeg", "crf": 1}, r"crf=1: wanted 2\.\.31"),
        ({"bit_rate_kbps": 0.0}, "bit_rate_kbps=0.0: wanted"),
        ({"frames": 0}, "frames=0: wanted"),
        ({"frames_per_s": 0}, "frames_per_s=0: wanted"),
        ({"speed": "warp"}, "speed=warp: wanted one of ultrafast"),
        ({"margin_px": -1}, "margin_px=-1: wanted"),
        ({"surround": "sky"}, "surround=sky: wanted grey or edge"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_a_setting_out_of_range_is_refused(what: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Video(**what)


def test_broken_frames_are_refused() -> None:
    with pytest.raises(ImageContractError, match="srgb: got"):
        Video()(torch.zeros(1, 1, 1, 8, 8))
    with pytest.raises(InputError, match="origin_px"):
        Video()(recordings(1), origin_px=(0, -3))
