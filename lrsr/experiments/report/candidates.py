"""What does a page show of candidates? Each picture once, and lists that point to it."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import torch

from lrsr.images import resize_bicubic
from lrsr.pages import encode_face
from lrsr.pictures.picture import Picture

_MOST_PROBES = 40
"""Of a table; results.json has all."""

_THUMB_PX = 96


class _Pictures(Protocol):
    @property
    def names(self) -> Sequence[str]: ...

    def load(self, start: int, stop: int) -> list[Picture]: ...


def shown_candidates(
    candidates: Sequence[Mapping[str, Any]], probes: _Pictures, gallery: _Pictures
) -> dict[str, Any]:
    """Return what the page of ``own`` prints of candidates.

    Args:
        candidates: Records as in ``results.json``.
        probes: The pictures.
        gallery: The enrolled ones.

    Returns:
        ``lists``: by title of the system, by probe, its candidates; ``thumbs``: data URIs by the
        name of a style, ``p`` or ``g`` and the number of the picture; ``style``: that name by
        picture; ``n_probes``: of all.
    """
    lists: dict[str, dict[str, list[Mapping[str, Any]]]] = {}
    for one in candidates:
        title = f"{one['recogniser']}, {one['label']}, {one['landmarks']} landmarks"
        members = lists.setdefault(title, {})
        if one["probe"] in members or len(members) < _MOST_PROBES:
            members.setdefault(one["probe"], []).append(one)
    shown = [one for members in lists.values() for some in members.values() for one in some]
    style: dict[str, dict[str, str]] = {}
    thumbs: dict[str, str] = {}
    for kind, pictures in (("probe", probes), ("gallery", gallery)):
        wanted = {one[kind] for one in shown}
        numbers = {name: k for k, name in enumerate(pictures.names) if name in wanted}
        style[kind] = {name: f"{kind[0]}{k}" for name, k in numbers.items()}
        for name, k in numbers.items():
            (picture,) = pictures.load(k, k + 1)
            thumbs[style[kind][name]] = encode_face(_thumb(picture.image))
    n_probes = len({one["probe"] for one in candidates})
    return {"lists": lists, "style": style, "thumbs": thumbs, "n_probes": n_probes}


def _thumb(image: torch.Tensor) -> torch.Tensor:
    """Return ``(3, h, w)`` with a shorter side of 96 px at most, by a whole factor."""
    factor = min(image.shape[1:]) // _THUMB_PX
    if factor < 2:
        return image
    height, width = (size - size % factor for size in image.shape[1:])
    return resize_bicubic(image[None, :, :height, :width], 1 / factor)[0]
