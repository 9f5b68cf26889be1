"""How do a network's numbers become boxes and landmarks? Anchors and offsets, in NumPy.

Every function takes the outputs that the contract names, each ``(B, n, C)``, and the height and
width of the images that the network saw, and returns candidates in pixels of these.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from lrsr.errors import InputError
from lrsr.recognition.detection.contract import DetectorContract
from lrsr.recognition.detection.faces import Array, Candidates

_MXNET_MIDDLE_PX = 7.5
"""Middle of MXNet's first anchor, which covers the pixels 0 to 15, whatever the stride."""


def decode(
    contract: DetectorContract, outputs: Sequence[Array], height: int, width: int
) -> Candidates:
    """Turn a network's outputs into candidates.

    Args:
        contract: Of the network.
        outputs: ``(B, n, C)``, those that the contract names.
        height: Of the images that it saw, px.
        width: Of the images that it saw, px.

    Raises:
        InputError: The outputs have other sizes than the contract's strides and anchors give.
    """
    try:
        return _DECODERS[contract.kind](contract, outputs, height, width)
    except ValueError as error:
        shapes = ", ".join(
            f"{name} {array.shape[1:]}" for name, array in zip(contract.names, outputs, strict=True)
        )
        raise InputError(
            f"outputs {shapes} for {height}x{width} px do not fit strides and anchors of kind"
            f" {contract.kind}: mend the contract"
        ) from error


def _retinaface(
    contract: DetectorContract, outputs: Sequence[Array], height: int, width: int
) -> Candidates:
    """Decode as biubug6/Pytorch_Retinaface, ``utils/box_utils.py``: decode and decode_landm."""
    scores, offsets, points = outputs
    places, sizes = [], []
    for stride, some in zip(contract.strides, contract.sizes_px, strict=True):
        places.append(_cells(stride, len(some), stride / 2, height, width))
        sizes.append(np.tile(some, len(places[-1]) // len(some)))
    centre, size = np.concatenate(places), np.concatenate(sizes)[:, None]
    of_places, of_sizes = contract.variances
    middle = centre + of_places * offsets[..., :2] * size
    half = size * np.exp(of_sizes * offsets[..., 2:]) / 2
    return Candidates(
        scores[..., 1],
        np.concatenate([middle - half, middle + half], axis=-1),
        centre[:, None] + of_places * _pairs(points) * size[..., None],
    )


def _scrfd(
    contract: DetectorContract, outputs: Sequence[Array], height: int, width: int
) -> Candidates:
    """Decode as insightface 2.1, ``model_zoo/scrfd.py``: distances from the anchor to the sides."""
    count, strides = len(contract.strides), contract.strides
    centre = np.concatenate([_cells(s, contract.per_cell, 0, height, width) for s in strides])
    scores = np.concatenate(outputs[:count], axis=1)[..., 0]
    away = _times(strides, outputs[count : 2 * count])
    if len(outputs) > 2 * count:
        landmarks = centre[:, None] + _pairs(_times(strides, outputs[2 * count :]))
    else:
        landmarks = np.full((*scores.shape, 5, 2), np.nan, dtype=np.float32)
    boxes = np.concatenate([centre - away[..., :2], centre + away[..., 2:]], axis=-1)
    return Candidates(scores, boxes, landmarks)


def _retinaface_deepface(
    contract: DetectorContract, outputs: Sequence[Array], height: int, width: int
) -> Candidates:
    """Decode as retina-face 0.0.19, ``commons/postprocess.py``, but for cutting boxes at the edge.

    A box names its first and last pixel, so that its width is their difference and 1.
    """
    parts = []
    for k, (stride, some) in enumerate(zip(contract.strides, contract.sizes_px, strict=True)):
        scores, offsets, points = outputs[3 * k : 3 * k + 3]
        images, anchors = len(scores), len(some)
        centre = _cells(stride, anchors, _MXNET_MIDDLE_PX, height, width)
        size = np.tile(some, len(centre) // anchors)[:, None]
        offsets = offsets.reshape(images, -1, 4)
        middle, half = (
            centre + offsets[..., :2] * size,
            (size * np.exp(offsets[..., 2:]) - 1) / 2,
        )
        boxes = np.concatenate([middle - half, middle + half], axis=-1)
        landmarks = centre[:, None] + _pairs(points.reshape(images, -1, 10)) * size[..., None]
        parts.append((scores[..., anchors:].reshape(images, -1), boxes, landmarks))
    return Candidates(*(np.concatenate(some, axis=1) for some in zip(*parts, strict=True)))


def _cells(stride: int, per_cell: int, middle_px: float, height: int, width: int) -> Array:
    """Return ``(cells * per_cell, 2)`` (x, y) of all anchors' middles, row by row.

    Example:
        >>> _cells(8, 1, 4, 8, 16).tolist()
        [[4.0, 4.0], [12.0, 4.0]]
    """
    y, x = np.mgrid[: -(-height // stride), : -(-width // stride)]
    cells = np.stack([x, y], axis=-1).reshape(-1, 2) * stride + middle_px
    return np.repeat(cells.astype(np.float32), per_cell, axis=0)


def _times(strides: Sequence[int], lists: Sequence[Array]) -> Array:
    """Multiply each stride's list ``(B, n, C)`` with it and join them."""
    scaled = [stride * some for stride, some in zip(strides, lists, strict=True)]
    return np.concatenate(scaled, axis=1)


def _pairs(points: Array) -> Array:
    """Return ``(B, n, 5, 2)`` of ``(B, n, 10)``."""
    return points.reshape(*points.shape[:-1], 5, 2)


_DECODERS: Mapping[str, Callable[[DetectorContract, Sequence[Array], int, int], Candidates]] = {
    "retinaface": _retinaface,
    "scrfd": _scrfd,
    "retinaface_deepface": _retinaface_deepface,
}
