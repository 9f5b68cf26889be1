"""What does a picture show between its pixels? Keys' cubic, as everywhere here (a = -0.5)."""

import numpy as np
import torch
from scipy.sparse import csr_array
from torch.nn import functional as F

_FEW, _MANY = 8, 64
"""Images looked at together, each in its own places or all in the same: what caches hold."""


def _cubic_weights(offset: torch.Tensor) -> list[torch.Tensor]:
    """Return the weights of the four pixels around a point (Keys 1981, eq. 15).

    Args:
        offset: Any shape, [0, 1): how far the point lies past the second of them, px.

    Example:
        >>> [round(float(weight), 4) for weight in _cubic_weights(torch.tensor(0.5))]
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
    parts = zip(torch.split(images, _FEW), torch.split(points_px, _FEW), strict=True)
    return torch.cat([_sample_each(*part) for part in parts])


def bicubic_matrix(points_px: torch.Tensor, height: int, width: int) -> csr_array:
    """Return what :func:`sample_bicubic` does to one picture, to do it, or undo it, many times.

    Args:
        points_px: ``(P, 2)`` (x, y).
        height: Of the picture.
        width: The same.

    Returns:
        ``(P, height * width)``, which times the picture's pixels, a row each, is what is seen.

    Example:
        >>> ramp = torch.arange(8.0).repeat(8)
        >>> (bicubic_matrix(torch.tensor([[3.25, 4.0]]), 8, 8) @ ramp.numpy()).tolist()
        [3.25]
    """
    index, weights = _surroundings(points_px, height, width)
    each = np.arange(len(index) + 1) * index.shape[1]
    parts = (weights.flatten().numpy(), index.flatten().numpy(), each)
    matrix = csr_array(parts, shape=(len(index), height * width))
    matrix.sum_duplicates()
    return matrix


def _sample_alike(images: torch.Tensor, points_px: torch.Tensor) -> torch.Tensor:
    """Look at the same places ``(M, h, w, 2)`` of all images.

    Each pixel is a row with its value in many images, so that one fetch serves them all: ten times
    faster than looking at one image after the other.
    """
    height, width = images.shape[-2:]
    every = images.shape[1] // len(points_px)  # channels that share their places
    alike = [_surroundings(points, height, width) for points in points_px.flatten(1, 2)]
    parts = []
    for few in torch.split(images, _MANY):
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
    x, y = points_px.flatten(2, 3).unbind(-1)
    columns = _neighbours(x, width)
    result = pixels.new_zeros(batch, channels, x.shape[-1])
    for row, down in _neighbours(y, height):
        line = torch.zeros_like(result)
        for column, right in columns:
            line = line + right * pixels.gather(2, (row * width + column).expand_as(result))
        result = result + down * line
    return result.reshape(batch, channels, *points_px.shape[2:4])


def _surroundings(
    points_px: torch.Tensor, height: int, width: int
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return indices and weights ``(P, 16)`` of the pixels around points ``(P, 2)``."""
    x, y = points_px.unbind(-1)
    columns, rows = _neighbours(x, width), _neighbours(y, height)
    index = [row * width + column for row, _ in rows for column, _ in columns]
    weights = [down * right for _, down in rows for _, right in columns]
    return torch.stack(index, dim=-1), torch.stack(weights, dim=-1)


def _neighbours(place: torch.Tensor, length: int) -> list[tuple[torch.Tensor, torch.Tensor]]:
    """Return index and weight of each of the four pixels around a place along one side."""
    corner = place.detach().floor()
    weights = _cubic_weights(place - corner)
    steps = [(corner.long() + step).clamp(0, length - 1) for step in (-1, 0, 1, 2)]
    return list(zip(steps, weights, strict=True))
