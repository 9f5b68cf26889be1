"""How is a face brought to the embedder's 112×112 pixels? Five points, one similarity, no rounding.

That is the template ``arcface5``. ``eyes`` takes the eyes alone, which are half as sure as five
points (2 to 2.5 times the error, at the same noise of each), and ``deepface`` does what DeepFace
does: see :mod:`lrsr.recognition.deepface_crop`.

A landmark's coordinate is 0 at the centre of pixel (0, 0), as in :mod:`lrsr.images`, in OpenCV and
in insightface's template. All is floating point: rounding landmarks to whole pixels costs 2.3° of
roll at 10 px between the eyes, and 0.6° after a fourfold enlargement, which would be credited to
the enlargement.

The warp is bilinear. A face of 10 px between the eyes is therefore enlarged 3.5 times bilinearly by
the alignment itself, whatever came before it.
"""

from typing import Literal, get_args

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import ImageContractError
from lrsr.evaluation.arrays import plain_array
from lrsr.images import check_images
from lrsr.recognition.deepface_crop import Levels, cut_face, fit_to_square

Template = Literal["arcface5", "eyes", "deepface"]
TEMPLATES: tuple[Template, ...] = get_args(Template)

CROP_PX = 112
"""Side of the aligned face that :data:`TEMPLATE_PX` is made for, px."""
_FARTHEST = 4
"""A face that is cut off may reach beyond its picture, but not so many times."""

TEMPLATE_PX: NDArray[np.float64] = np.array(
    [
        [38.2946, 51.6963],
        [73.5318, 51.5014],
        [56.0252, 71.7366],
        [41.5493, 92.3655],
        [70.7299, 92.2041],
    ]
)
"""Where ArcFace wants left eye, right eye, nose, left and right mouth corner: ``(5, 2)``, px."""

TEMPLATE_IPD_PX = float(np.linalg.norm(TEMPLATE_PX[1] - TEMPLATE_PX[0]))
"""Distance of the eyes in the aligned face: 35.24 px."""

_EYES_PX = np.column_stack([TEMPLATE_PX[:2, 0], np.full(2, TEMPLATE_PX[:2, 1].mean())])
"""Where ``eyes`` wants them: ArcFace's columns, in its mean row, so level."""

_BOX_IPDS = np.array([[-1.06, -1.22], [1.06, 1.93]])
"""Left top, right bottom of a box from the middle of the eyes, in distances of these: the median of
the shipped detector's on 20 rendered faces."""


def read_landmarks(landmarks_px: ArrayLike, count: int | None = None) -> NDArray[np.float64]:
    """Turn landmarks of any kind into numbers: lists, arrays, masked ones, tensors of any type.

    Args:
        landmarks_px: ``(B, 5, 2)``, (x, y) in px; what is masked becomes NaN, no face was found.
        count: The B that is wanted, if any.

    Returns:
        ``(B, 5, 2)`` float64.

    Raises:
        ImageContractError: They are no numbers, or have another shape.

    Example:
        >>> read_landmarks(torch.zeros(1, 5, 2, dtype=torch.bfloat16)).shape
        (1, 5, 2)
    """
    wanted = f"wanted ({'B' if count is None else count}, 5, 2)"
    points = plain_array(
        landmarks_px,
        "landmarks_px",
        wanted=f"{wanted.removeprefix('wanted ')} numbers",
        error=ImageContractError,
        masked=np.nan,
    )
    if points.ndim != 3 or points.shape[1:] != (5, 2) or count not in (None, len(points)):
        raise ImageContractError(f"landmarks_px: got shape {points.shape}, {wanted}")
    return np.asarray(points, dtype=np.float64)


def fit_similarities(
    landmarks_px: ArrayLike, target_px: NDArray[np.float64] = TEMPLATE_PX
) -> NDArray[np.float64]:
    """Fit rotation, uniform scale and shift from landmarks onto a template, least squares.

    Umeyama, *Least-squares estimation of transformation parameters between two point patterns*
    (1991), equations 40 to 43, without reflections.

    Args:
        landmarks_px: ``(B, 5, 2)``, (x, y) in px of each image.
        target_px: ``(n, 2)``, where the first n of them shall come to lie.

    Returns:
        ``(B, 2, 3)``: maps (x, y, 1) of the image to the crop. All NaN where one of these is not
        finite or all coincide: there is no face to align.

    Raises:
        ImageContractError: The landmarks have another shape.

    Example:
        >>> (fit_similarities(TEMPLATE_PX[None] * 2)[0].round(6) + 0.0).tolist()
        [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0]]
    """
    count = len(target_px)
    points = read_landmarks(landmarks_px)[:, :count]
    matrices = np.full((len(points), 2, 3), np.nan)
    usable = np.flatnonzero(np.isfinite(points).all(axis=(1, 2)))
    usable = usable[np.ptp(points[usable], axis=1).max(axis=1) > 1e-6]
    source = points[usable]
    source_mean = source.mean(axis=1)
    target_mean = target_px.mean(axis=0)
    centred = source - source_mean[:, None]
    covariance = np.einsum("kd,bke->bde", target_px - target_mean, centred) / count
    u, singular, vt = np.linalg.svd(covariance)
    signs = np.ones_like(singular)
    signs[:, 1] = np.where(np.linalg.det(u) * np.linalg.det(vt) < 0, -1.0, 1.0)
    rotation = np.einsum("bij,bj,bjk->bik", u, signs, vt)
    variance = np.square(centred).sum(axis=(1, 2)) / count
    scale = (singular * signs).sum(axis=1) / variance
    linear = scale[:, None, None] * rotation
    matrices[usable, :, :2] = linear
    matrices[usable, :, 2] = target_mean - np.einsum("bij,bj->bi", linear, source_mean)
    return matrices


def warp(
    images: torch.Tensor,
    matrices: NDArray[np.float64],
    *,
    size_px: int,
    antialias: bool,
    outside: Literal["zeros", "border"] = "zeros",
) -> torch.Tensor:
    """Resample images through ``matrices``, bilinearly.

    Args:
        images: ``(B, C, H, W)`` float32, any range.
        matrices: ``(B, 2, 3)``, image (x, y, 1) to result; finite and invertible.
        size_px: Height and width of the result, px.
        antialias: Where the result is smaller than the image, average k×k bilinear samples per
            pixel of the result, k = the minification rounded up. Off: one sample, as insightface.
        outside: What lies outside an image: black, as insightface, or the nearest pixel's colour.

    Returns:
        ``(B, C, size_px, size_px)`` float32.
    """
    full = np.zeros((len(images), 3, 3))
    full[:, :2], full[:, 2, 2] = matrices, 1
    inverses = np.linalg.inv(full)
    rays = np.ones(len(images), dtype=np.int64)
    if antialias:
        minification = np.sqrt(np.abs(np.linalg.det(inverses)))
        rays = np.maximum(1, np.ceil(minification - 0.01)).astype(np.int64)
    height, width = images.shape[-2:]
    source, target = _unit_square(height, width), np.linalg.inv(_unit_square(size_px, size_px))
    theta = torch.from_numpy(source @ inverses @ target)[:, :2].to(images)
    result = images.new_empty(len(images), images.shape[1], size_px, size_px)
    for k in np.unique(rays).tolist():
        rows = torch.from_numpy(np.flatnonzero(rays == k))
        shape = [len(rows), 1, k * size_px, k * size_px]
        grid = F.affine_grid(theta[rows], shape, align_corners=False)
        fine = F.grid_sample(images[rows], grid, padding_mode=outside, align_corners=False)
        result[rows] = F.avg_pool2d(fine, k) if k > 1 else fine
    return result


def _unit_square(height: int, width: int) -> NDArray[np.float64]:
    """Return the ``(3, 3)`` map from pixels to PyTorch's [-1, 1], edge to edge of the image."""
    return np.array([[2 / width, 0, 1 / width - 1], [0, 2 / height, 1 / height - 1], [0, 0, 1]])


def align(
    srgb: torch.Tensor,
    landmarks_px: ArrayLike,
    *,
    antialias: bool,
    template: Template = "arcface5",
    boxes_px: ArrayLike | None = None,
    size_px: tuple[int, int] = (CROP_PX, CROP_PX),
) -> tuple[torch.Tensor, NDArray[np.bool_]]:
    """Bring faces to an embedder's pixels.

    Args:
        srgb: ``(B, 3, H, W)`` float32, srgb, [0, 1].
        landmarks_px: ``(B, 5, 2)``; a NaN, or a mask, says that no face was found.
        antialias: See :func:`warp`; not of ``deepface``.
        template: How, see the module.
        boxes_px: ``(B, 4)`` left, top, right, bottom of each face, which ``deepface`` alone needs;
            None: where a detector's box lies about such eyes on average.
        size_px: Height h and width w of a crop. The template is multiplied by h / 112, as
            insightface does, and centred in the width; ``deepface`` wants them equal.

    Returns:
        The crops ``(B, 3, h, w)``, black where no face was found, and ``(B,)``: was one found?

    Raises:
        ImageContractError: Images or landmarks have another shape, their numbers differ, or the
            landmarks are much farther apart than the picture is large.
    """
    check_images(srgb, name="srgb")
    matrices = fit_similarities(landmarks_px, TEMPLATE_PX if template == "arcface5" else _EYES_PX)
    if len(matrices) != len(srgb):
        raise ImageContractError(f"{len(srgb)} images but landmarks for {len(matrices)}")
    found: NDArray[np.bool_] = np.isfinite(matrices[:, 0, 0])
    height, width = size_px
    crops = srgb.new_zeros(len(srgb), 3, height, width)
    if not found.any():
        return crops, found
    points = read_landmarks(landmarks_px)
    spread, size = np.nanmax(np.ptp(points[found], axis=1)), srgb.shape[-2:]
    if spread > _FARTHEST * max(size):
        raise ImageContractError(
            f"landmarks_px: {spread:g} px from one to another in pictures of {tuple(size)},"
            f" wanted at most {_FARTHEST} times the picture"
        )
    if template == "deepface":
        boxes = _boxes_about(points) if boxes_px is None else np.asarray(boxes_px, np.float64)
        for row in np.flatnonzero(found):
            face = cut_face(_levels(srgb[row]), boxes[row], points[row, :2])
            found[row] = face is not None
            crops[row] = crops[row] if face is None else _srgb(fit_to_square(face, height))
    else:
        rows, fitted = torch.from_numpy(found), matrices[found] * (height / CROP_PX)
        fitted[:, 0, 2] += (width - height) / 2
        square = warp(srgb[rows], fitted, size_px=max(size_px), antialias=antialias)
        crops[rows] = square[:, :, :height, :width]
    return crops, found


def whole_pictures(srgb: torch.Tensor, side_px: int = CROP_PX) -> torch.Tensor:
    """Bring whole pictures to a square, as DeepFace does where it finds no face.

    Args:
        srgb: ``(B, 3, H, W)`` float32, srgb, [0, 1].
        side_px: Of the square.

    Returns:
        ``(B, 3, side_px, side_px)``.
    """
    return torch.stack([_srgb(fit_to_square(_levels(one), side_px)) for one in srgb])


def landmark_errors(found_px: ArrayLike, true_px: ArrayLike) -> NDArray[np.float64]:
    """Measure how far landmarks lie from the true ones.

    Args:
        found_px: ``(B, 5, 2)``; NaN: no face.
        true_px: ``(B, 5, 2)``; NaN: not known.

    Returns:
        ``(B,)`` mean distance of the five in distances between the true eyes on the picture; NaN
        where either is missing.

    Example:
        >>> landmark_errors(TEMPLATE_PX[None] + [3.5237, 0], TEMPLATE_PX[None]).round(3).tolist()
        [0.1]
    """
    found, true = read_landmarks(found_px), read_landmarks(true_px)
    eyes_px = np.linalg.norm(true[:, 1] - true[:, 0], axis=-1)
    errors: NDArray[np.float64] = np.linalg.norm(found - true, axis=-1).mean(axis=1) / eyes_px
    return errors


def _boxes_about(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``(B, 4)`` boxes about eyes ``(B, 5, 2)``."""
    eyes_px = np.linalg.norm(points[:, 1] - points[:, 0], axis=-1)
    middle = points[:, :2].mean(axis=1, keepdims=True)
    boxes: NDArray[np.float64] = (middle + eyes_px[:, None, None] * _BOX_IPDS).reshape(-1, 4)
    return boxes


def _levels(srgb: torch.Tensor) -> Levels:
    """Return one image ``(3, H, W)`` as ``(H, W, 3)`` of 8 bits."""
    levels: Levels = srgb.mul(255).round().to(torch.uint8).permute(1, 2, 0).numpy(force=True)
    return np.ascontiguousarray(levels)


def _srgb(levels: Levels) -> torch.Tensor:
    return torch.from_numpy(levels).permute(2, 0, 1).float() / 255
