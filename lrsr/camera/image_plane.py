"""Where on the sensor does each pixel of a crop lie, and what does a camera see that looks there?

Places on the sensor are in mm from the point where the optical axis meets it: right and down, as in
the picture. Pixels follow :mod:`lrsr.images`: 0 is the centre of the top-left one.
"""

import torch

from lrsr.errors import InputError

Field = tuple[float, float] | torch.Tensor


def read_field(field_mm: Field, images: torch.Tensor, radius_mm: float) -> torch.Tensor:
    """Return the places of the crops' centres as ``(N, 2)``, N = 1 or B, like ``images``.

    Args:
        field_mm: (right, down), or a tensor ``(2,)`` or ``(B, 2)``, mm.
        images: ``(B, C, H, W)``.
        radius_mm: No place lies farther out.

    Raises:
        InputError: Another shape, or a place off the sensor.
    """
    field = torch.as_tensor(field_mm, dtype=images.dtype, device=images.device)
    if tuple(field.shape) not in ((2,), (1, 2), (len(images), 2)):
        raise InputError(
            f"field_mm of shape {tuple(field.shape)}: give (right, down), or one such row for each "
            f"of the {len(images)} images"
        )
    field = field.reshape(-1, 2)
    farthest = float(field.detach().square().sum(1).max()) ** 0.5
    if not farthest <= radius_mm:
        raise InputError(
            f"field_mm: a crop {farthest:.4g} mm from the optical axis lies off the sensor, whose "
            f"edge is at {radius_mm:g} mm"
        )
    return field


def pixels_to_mm(
    points_px: torch.Tensor, size: tuple[int, int], pitch_mm: float, field: torch.Tensor
) -> torch.Tensor:
    """Turn pixels of a crop into places on the sensor.

    Args:
        points_px: ``(..., 2)`` (x, y), px of the crop.
        size: (height, width) of the crop, px.
        pitch_mm: Of its pixels, mm.
        field: Its centre, mm; broadcasts with ``points_px``.

    Example:
        >>> middle = torch.tensor([1.5, 0.5])
        >>> pixels_to_mm(middle, (2, 4), 0.1, torch.tensor([2.0, 1.0])).tolist()
        [2.0, 1.0]
    """
    return (points_px - _middle(points_px, size)) * pitch_mm + field


def mm_to_pixels(
    points_mm: torch.Tensor, size: tuple[int, int], pitch_mm: float, field: torch.Tensor
) -> torch.Tensor:
    """Invert :func:`pixels_to_mm`."""
    return (points_mm - field) / pitch_mm + _middle(points_mm, size)


def pixel_grid(size: tuple[int, int], like: torch.Tensor) -> torch.Tensor:
    """Return ``(height, width, 2)``: (x, y) of every pixel, in the dtype of ``like``."""
    rows, columns = (torch.arange(n, dtype=like.dtype, device=like.device) for n in size)
    return torch.stack(torch.meshgrid(columns, rows, indexing="xy"), dim=-1)


def turn(
    points_mm: torch.Tensor, centre_mm: torch.Tensor, focal_mm: float, *, back: bool = False
) -> torch.Tensor:
    """Turn a pinhole camera so that it faces ``centre_mm``, without rolling it.

    Args:
        points_mm: ``(..., 2)`` on the plane of the straight camera, mm.
        centre_mm: What comes to lie on the axis of the turned one, mm, same plane; broadcasts.
        focal_mm: Of both, mm.
        back: From the turned camera's plane to the straight one's.

    Returns:
        ``(..., 2)`` on the plane of the turned camera, mm.

    Example:
        >>> corner = torch.tensor([3.0, 0.0])
        >>> turn(corner, corner, 3.0).tolist()
        [0.0, 0.0]
    """
    sign = -1 if back else 1
    along = (points_mm * centre_mm).sum(-1, keepdim=True)
    ray = (centre_mm.square().sum(-1, keepdim=True) + focal_mm**2).sqrt()
    # Rodrigues' rotation, written so that nothing is divided by a centre's distance of 0.
    turned = points_mm - centre_mm * (along / (ray + focal_mm) + sign * focal_mm) / ray
    ahead = (sign * along + focal_mm**2) / ray
    return turned * focal_mm / ahead


def _middle(like: torch.Tensor, size: tuple[int, int]) -> torch.Tensor:
    height, width = size
    return torch.tensor([(width - 1) / 2, (height - 1) / 2], dtype=like.dtype, device=like.device)
