"""A scene whose blurred picture is known at every point by formula: a sum of plane waves."""

import torch

_COUNT = 40


def _waves() -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Frequencies up to 0.7 cycles a pixel, beyond what one frame can hold; phases; colours."""
    generator = torch.Generator().manual_seed(0)
    way = torch.rand(_COUNT, generator=generator) * torch.pi
    length = torch.rand(_COUNT, generator=generator) * 0.7
    frequency = length[:, None] * torch.stack([way.cos(), way.sin()], dim=1)
    phase = torch.rand(_COUNT, generator=generator) * 2 * torch.pi
    height = 0.5 + torch.rand(3, _COUNT, generator=generator)
    return frequency, phase, height / (1 + 6 * length) * 0.07


def picture(
    side: int, motion: torch.Tensor | None = None, *, finer: int = 1, blur_px: float = 0.5
) -> torch.Tensor:
    """Photograph the scene, ``(3, finer * side, finer * side)``.

    Args:
        side: Of the frame, px.
        motion: ``(2, 3)``: what is at (x, y) in the scene is at M (x, y, 1) of this frame.
        finer: How many times finer the picture is than the frame.
        blur_px: Standard deviation of the camera's Gaussian, px of the frame.
    """
    frequency, phase, height = (each.double() for each in _waves())
    line = (torch.arange(side * finer, dtype=torch.float64) + 0.5) / finer - 0.5
    points = torch.stack(torch.meshgrid(line, line, indexing="xy"), dim=-1)
    if motion is not None:
        turn, shift = motion.double()[:, :2], motion.double()[:, 2]
        points = (points - shift) @ torch.linalg.inv(turn).T
    passed = torch.exp(-2 * (torch.pi * blur_px) ** 2 * (frequency**2).sum(dim=1))
    waves = torch.cos(2 * torch.pi * points @ frequency.T + phase) * passed
    return (0.5 + torch.einsum("ck,hwk->chw", height, waves)).float()


def shifted(right: float, down: float, turn_deg: float = 0.0) -> torch.Tensor:
    """Return a motion that turns about the origin and then shifts."""
    angle = torch.deg2rad(torch.tensor(turn_deg, dtype=torch.float64))
    c, s = angle.cos(), angle.sin()
    return torch.tensor([[c, -s, right], [s, c, down]], dtype=torch.float64)
