import math

import pytest
import torch
import torch.nn.functional as F

from lrsr.training.margin import AngularMargin


def head_at(*angles: float, scale: float = 32.0, margin: float = 0.5) -> AngularMargin:
    """Directions at these angles in the plane."""
    head = AngularMargin(2, len(angles), scale=scale, margin=margin)
    directions = torch.tensor([[math.cos(a), math.sin(a)] for a in angles])
    with torch.no_grad():
        head.directions.copy_(5 * directions)
    return head


def at(angle: float, length: float = 3.0) -> torch.Tensor:
    return length * torch.tensor([[math.cos(angle), math.sin(angle)]])


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.5, 2.6])
def test_the_right_person_is_moved_by_the_margin(angle: float) -> None:
    logits = head_at(0.0, 2.0)(at(angle), torch.tensor([0]))[0].tolist()
    assert logits[0] == pytest.approx(32 * math.cos(angle + 0.5), abs=0.02)
    assert logits[1] == pytest.approx(32 * math.cos(angle - 2.0), abs=1e-4)


def test_beyond_pi_the_score_goes_on_falling() -> None:
    angle = math.pi - 0.2
    logits = head_at(0.0)(at(angle), torch.tensor([0]))
    assert float(logits.detach()) == pytest.approx(
        32 * (math.cos(angle) - 0.5 * math.sin(0.5)), abs=1e-3
    )


def test_the_score_falls_with_the_angle_everywhere() -> None:
    head = head_at(0.0)
    angles = torch.linspace(0.01, math.pi - 0.01, 200)
    embeddings = torch.stack([angles.cos(), angles.sin()], dim=1)
    scores = head(embeddings, torch.zeros(200, dtype=torch.int64))[:, 0]
    assert bool((scores.diff() < 0).all())


def test_without_a_margin_it_is_a_softmax_of_cosines() -> None:
    head = head_at(0.0, 1.0, scale=10.0, margin=0.0)
    logits = head(at(0.4), torch.tensor([1]))
    torch.testing.assert_close(logits, 10 * head.cosines(at(0.4)), atol=1e-4, rtol=0)


def test_length_does_not_matter() -> None:
    head = head_at(0.0, 1.0)
    people = torch.tensor([1])
    torch.testing.assert_close(head(at(0.4, 0.1), people), head(at(0.4, 90), people))


def test_the_gradient_is_finite_even_on_the_right_spot() -> None:
    embedding = at(0.0).requires_grad_()
    F.cross_entropy(head_at(0.0, 2.0)(embedding, torch.tensor([0])), torch.tensor([0])).backward()
    assert embedding.grad is not None
    assert bool(torch.isfinite(embedding.grad).all())
