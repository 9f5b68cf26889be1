from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.contracts import declare
from fakes.networks import write_tones

from lrsr.errors import InputError
from lrsr.paths import asset
from lrsr.recognition.alignment import TEMPLATE_PX, align
from lrsr.recognition.embedding import Embedder
from lrsr.training.losses.identity import IdentityLoss


def faces(seed: int, side: int = 48) -> torch.Tensor:
    """Two smooth pictures."""
    tones = torch.rand(2, 3, 6, 6, generator=torch.Generator().manual_seed(seed))
    return torch.nn.functional.interpolate(tones, size=(side, side), mode="bilinear")


LANDMARKS = torch.from_numpy(TEMPLATE_PX).float().mul(48 / 112).expand(2, 5, 2)


def test_it_is_one_minus_the_cosine_that_recognition_would_find() -> None:
    loss = IdentityLoss(weight=1)
    embedder = Embedder(asset("weights/arcface_small.onnx"))
    restored, true = (embedder(align(faces(seed), LANDMARKS, antialias=True)[0]) for seed in (0, 1))
    expected = 1 - (restored * true).sum(1).mean()
    assert float(loss(faces(0), faces(1), LANDMARKS)) == pytest.approx(expected, abs=1e-5)
    assert 0.01 < expected < 2


def test_the_true_face_loses_nothing() -> None:
    loss = IdentityLoss(weight=1)
    assert float(loss(faces(0), faces(0), LANDMARKS)) == pytest.approx(0.0, abs=1e-5)


def test_its_gradient_leads_to_the_true_face() -> None:
    loss, restored = IdentityLoss(weight=1), faces(0).requires_grad_()
    before = loss(restored, faces(1), LANDMARKS)
    before.backward()
    assert restored.grad is not None
    after = loss(restored.detach() - 2.0 * restored.grad, faces(1), LANDMARKS)
    assert float(after) < float(before.detach())


@pytest.mark.parametrize("layout", ["NCHW", "NHWC"])
def test_an_embedder_of_anothers_is_given_what_its_contract_says(
    layout: str, tmp_path: Path
) -> None:
    model = write_tones(tmp_path / "tones.onnx", layout=layout)
    declare(model, 147, layout=layout, channels="BGR", mean=(104.0, 117.0, 123.0), scale=1.0)
    loss, embedder = IdentityLoss(weight=1, embedder=str(model)), Embedder(model)
    restored, true = (
        embedder(align(faces(seed), LANDMARKS, antialias=False)[0]) for seed in (0, 1)
    )
    expected = 1 - np.sum(restored * true, axis=1).mean()
    assert float(loss(faces(0), faces(1), LANDMARKS)) == pytest.approx(expected, abs=1e-5)


def test_the_embedder_is_in_no_checkpoint() -> None:
    loss = IdentityLoss(weight=1)
    assert not loss.state_dict()
    assert not list(loss.parameters())


def test_patches_without_landmarks_are_refused() -> None:
    with pytest.raises(InputError, match="wanted whole faces; add patches=faces"):
        IdentityLoss(weight=1)(faces(0), faces(1))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"weight": -1}, "module.losses.identity.weight=-1: wanted at least 0"),
        ({"weight": "much"}, "module.losses.identity.weight=much: wanted a number"),
        ({"embedder": True}, "module.losses.identity.embedder=true: wanted a word"),
        ({"embedder": "nobodys"}, "no recogniser 'nobodys'"),
    ],
    ids=str,
)
def test_a_wrong_setting_is_named(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        IdentityLoss(**{"weight": 1, **wrong})


def test_an_alignment_without_a_gradient_is_refused(tmp_path: Path) -> None:
    model = declare(write_tones(tmp_path / "tones.onnx"), 147, template="deepface")
    with pytest.raises(InputError, match="no gradient passes through its alignment as DeepFace's"):
        IdentityLoss(weight=1, embedder=str(model))
