"""What does a picture show between its pixels? Keys' cubic, as everywhere here (a = -0.5)."""

import torch


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
    batch, channels, height, width = images.shape
    places = points_px.shape[2:4]
    x, y = points_px.flatten(2, 3).unbind(-1)
    left, top = x.detach().floor(), y.detach().floor()
    columns, rows = cubic_weights(x - left), cubic_weights(y - top)
    pixels = images.flatten(2)
    result = pixels.new_zeros(batch, channels, x.shape[-1])
    for down in range(4):
        start = (top + (down - 1)).clamp(0, height - 1).long() * width
        line = torch.zeros_like(result)
        for right in range(4):
            index = start + (left + (right - 1)).clamp(0, width - 1).long()
            line = line + columns[right] * pixels.gather(2, index.expand_as(result))
        result = result + rows[down] * line
    return result.unflatten(2, places)
