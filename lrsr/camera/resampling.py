"""What does a picture show between its pixels? Keys' cubic, as everywhere here (a = -0.5)."""

import torch
from torch.nn import functional as F

FEW, MANY = 8, 64
"""Images looked at together, each in its own places or all in the same: what caches hold."""


def cubic_weights(offset: torch.Tensor) -> list[torch.Tensor]:
    """Return the weights of the four pixels around a point (Keys 1981, eq. 15).

    Args:
        offset: Any shape, [0, 1): how far the point lies past the second of them, px.

    Example:
        >>> [round(float(weight), 4) for weight in cubic_weights(torch.tensor(0.5))]
        [-0.0625, 0.5625, 0.5625, -0.0625]
    """
    t = offset
    return [
        ((1 - 0.5 * t) * t - 0.5) * t,
        (1.5 * t - 2.5) * t**2 + 1,
        ((2 - 1.5 * t) * t + 0.5) * t,
        (0.5 * t - 0.5) * t**2,
    ]


def sample_bicubic(images: torch.Tensor, points_px: torch.Tensor) -> torch.Tensor:
    """Look at pictures in any places; beyond the border the edge pixel repeats.

    Nothing is smoothed: where the places lie more than a pixel apart, fine detail aliases.

    Args:
        images: ``(B, C, H, W)``, any H and W >= 1.
        points_px: ``(N, M, h, w, 2)`` (x, y), 0 is the centre of the top-left pixel; N is 1 (the
            same for all images) or B, M is 1 (for all channels) or C.

    Returns:
        ``(B, C, h, w)``, with a gradient to pictures and places.

    Example:
        >>> ramp = torch.arange(8.0).expand(1, 1, 8, 8)
        >>> sample_bicubic(ramp, torch.tensor([[[[[3.25, 4.0]]]]])).item()
        3.25
    """
    if len(points_px) == 1:
        return _sample_alike(images, points_px[0])
    parts = zip(torch.split(images, FEW), torch.split(points_px, FEW), strict=True)
    return torch.cat([_sample_each(*part) for part in parts])


def _sample_alike(images: torch.Tensor, points_px: torch.Tensor) -> torch.Tensor:
    """Look at the same places ``(M, h, w, 2)`` of all images.

    Each pixel is a row with its value in many images, so that one fetch serves them all: ten times
    faster than looking at one image after the other.
    """
    size = (images.shape[-2], images.shape[-1])
    every = images.shape[1] // len(points_px)  # channels that share their places
    alike = [_surroundings(points, size) for points in points_px.flatten(1, 2)]
    parts = []
    for few in torch.split(images, MANY):
        layers = []
        for channels, (index, weights) in zip(torch.split(few, every, dim=1), alike, strict=True):
            table = channels.flatten(2).permute(2, 0, 1).flatten(1).contiguous()
            seen = F.embedding_bag(index, table, per_sample_weights=weights, mode="sum")
            layers.append(seen.reshape(-1, len(few), every).permute(1, 2, 0))
        parts.append(torch.cat(layers, dim=1))
    places = points_px.shape[1:3]
    return torch.cat(parts).reshape(*images.shape[:2], *places)


def _sample_each(images: torch.Tensor, points_px: torch.Tensor) -> torch.Tensor:
    """Look at places ``(B, M, h, w, 2)`` of each image."""
    batch, channels, height, width = images.shape
    pixels = images.flatten(2)
    index, weights = _surroundings(points_px.flatten(2, 3), (height, width))
    result = pixels.new_zeros(batch, channels, index.shape[-2])
    for place, weight in zip(index.unbind(-1), weights.unbind(-1), strict=True):
        result = result + weight * pixels.gather(2, place.expand_as(result))
    return result.reshape(batch, channels, *points_px.shape[2:4])


def _surroundings(
    points_px: torch.Tensor, size: tuple[int, int]
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return indices and weights ``(..., 16)`` of the pixels around points ``(..., 2)``."""
    height, width = size
    corner = points_px.detach().floor()
    columns, rows = (
        torch.stack(cubic_weights(offset), dim=-1) for offset in (points_px - corner).unbind(-1)
    )
    steps = torch.arange(-1, 3, device=points_px.device)
    left, top = corner.long()[..., None].unbind(-2)
    index = (top + steps).clamp(0, height - 1)[..., None] * width
    index = index + (left + steps).clamp(0, width - 1)[..., None, :]
    return index.flatten(-2), (rows[..., None] * columns[..., None, :]).flatten(-2)
