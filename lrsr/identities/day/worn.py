"""What is worn over head and face that day? Glasses, a cap, a face mask, fitted to the head.

They are parts of the head like others, and there only on a day that may bring them: where chance
says that somebody wears none, theirs is folded up inside the skull, so that people of one day have
parts of the same names and faces.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from lrsr.identities.day.another_day import AnotherDay
from lrsr.identities.day.cap import Crown, build_cap, sample_cap
from lrsr.identities.day.face_mask import build_face_mask, sample_face_mask
from lrsr.identities.day.fit import Fit
from lrsr.identities.day.glasses import build_glasses, sample_glasses
from lrsr.identities.head import Part


def dress(
    parts: Sequence[Part],
    pupils: np.ndarray[Any, np.dtype[np.float64]],
    landmarks: np.ndarray[Any, np.dtype[np.float64]],
    day: AnotherDay,
    seed: int,
) -> tuple[tuple[Part, ...], dict[str, str]]:
    """Put on what that day brings.

    Args:
        parts: Of the head as it is that day, skin first.
        pupils: ``(2, 3)``, mm.
        landmarks: ``(5, 3)``, mm.
        day: What may be worn.
        seed: The person.

    Returns:
        All parts, hair pressed under a cap, and what is worn, by kind.
    """
    if not (day.glasses or day.cap or day.face_mask):
        return tuple(parts), {}
    fit = Fit(parts[0].vertices, pupils)
    worn: dict[str, str] = {}
    dressed = list(parts)
    things: list[Part] = []

    def keep(kind: str, what: str, made: Sequence[Part]) -> bool:
        is_worn = day.wears(seed, kind)
        things.extend(made if is_worn else [_folded(part, fit.centre) for part in made])
        worn.update({kind: what} if is_worn else {})
        return is_worn

    if day.glasses:
        ipd_mm = float(np.linalg.norm(pupils[1] - pupils[0]))
        glasses = sample_glasses(_taste(day, seed, "glasses"), ipd_mm)
        keep("glasses", glasses["shape"], build_glasses(glasses, fit))
    if day.cap:
        cap = sample_cap(_taste(day, seed, "cap"))
        crown = Crown(cap, fit)
        if keep("cap", cap["colour"], [build_cap(cap, crown)]):
            dressed = [crown.press(part) if part.name == "hair" else part for part in dressed]
    if day.face_mask:
        mask = sample_face_mask(_taste(day, seed, "face_mask"))
        keep("face_mask", mask["colour"], [build_face_mask(mask, fit, landmarks)])
    return (*dressed, *things), worn


def _taste(day: AnotherDay, seed: int, kind: str) -> np.random.Generator:
    """Return what a worn thing itself is drawn from, whether or not it is worn."""
    return day.stream(seed, kind).spawn(1)[0]


def _folded(part: Part, inside: np.ndarray[Any, np.dtype[np.float64]]) -> Part:
    """Return a part that nobody sees."""
    vertices = np.broadcast_to(inside.astype(np.float32), part.vertices.shape).copy()
    return replace(part, vertices=vertices)
