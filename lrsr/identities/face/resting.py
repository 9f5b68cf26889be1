"""What shape has a face at rest, and what shape when it acts? Both in one frame, the head's.

A face at rest is made of coefficients alone, in a few milliseconds: it is what the gate of
:mod:`lrsr.identities.gate.plausibility` judges before anything costly is made.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.expression import Expression
from lrsr.identities.face.eyes import Eyes, find_eyes
from lrsr.identities.face.lids import (
    BLINKS,
    blink_columns,
    clear_lids,
    closing_strengths,
    rest_lids,
)
from lrsr.identities.face.template import template
from lrsr.identities.shape.basis import BaseHead, load_basis

Points = NDArray[np.float64]


class RestingFace(NamedTuple):
    """A face that does nothing.

    Attributes:
        weights: ``(K,)`` coefficients, upper lids at rest.
        shape: Coarse head, head frame, mm.
        eyes: In the same frame.
        skin: ``(V, 3)`` render vertices, head frame, mm, clear of the eyes.
        rotation: ``(3, 3)`` from the axes of the basis to the head frame.
        origin: ``(3,)`` of the head frame, in those of the basis, mm.
    """

    weights: Points
    shape: BaseHead
    eyes: Eyes
    skin: Points
    rotation: Points
    origin: Points


def rest_face(weights: Points) -> RestingFace:
    """Shape a face at rest.

    Args:
        weights: ``(K,)`` coefficients: :func:`lrsr.identities.shape.anatomy.coefficients`.
    """
    return place_face(rest_lids(load_basis(), weights, template().lids))


def place_face(weights: Points, gazes: Points | None = None) -> RestingFace:
    """Shape a face whose lids are as they are to be, and put it into the head frame.

    Args:
        weights: ``(K,)`` coefficients, lids at rest.
        gazes: ``(2, 3)`` where the eyes look, in the axes of the basis; None: between their lids.
    """
    basis = load_basis()
    shaped = basis.shape(weights)
    eyes = find_eyes(basis, shaped)
    if gazes is not None:
        eyes = eyes._replace(gazes=gazes)
    rotation, origin = _head_frame(eyes)
    shape = _moved(shaped, rotation, origin)
    eyes = eyes.moved(rotation, origin)
    return RestingFace(weights, shape, eyes, _skin(shape, eyes), rotation, origin)


def act(face: RestingFace, expression: Expression) -> tuple[Points, Points]:
    """Let a face act. Its eyes stay: a blink moves lids, not the gaze, and closes any eyes.

    Args:
        face: At rest.
        expression: What it does.

    Returns:
        Coefficients ``(K,)`` and render vertices ``(V, 3)``, mm, in the frame of the face at rest.
    """
    basis = load_basis()
    acting = expression.act(basis, face.weights)
    if acting is face.weights:
        return acting, face.skin
    blinks = [expression.units.get(unit, 0.0) for unit in BLINKS]
    if any(blinks):
        beyond = closing_strengths(basis, face.weights, template().lids) - 1.0
        acting[blink_columns(basis)] += blinks * beyond
    return acting, acting_skin(face, acting)


def acting_skin(face: RestingFace, acting: Points) -> Points:
    """Return the skin of a face that acts, ``(V, 3)``, mm, in the frame of the face at rest.

    Args:
        face: At rest: its eyes stay.
        acting: ``(K,)`` coefficients of what it does.
    """
    return _skin(_moved(load_basis().shape(acting), face.rotation, face.origin), face.eyes)


def _head_frame(eyes: Eyes) -> tuple[Points, Points]:
    """Return rotation and origin that put the pupils on the x axis, their middle at the origin."""
    left, right = eyes.pupils
    x = (right - left) / np.linalg.norm(right - left)
    z = np.array([0.0, 0.0, 1.0])
    z = z - (z @ x) * x
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z]), (left + right) / 2


def _moved(shaped: BaseHead, rotation: Points, origin: Points) -> BaseHead:
    return BaseHead(*((part - origin) @ rotation.T for part in shaped))


def _skin(shape: BaseHead, eyes: Eyes) -> Points:
    return clear_lids(load_basis().surface.matrix @ shape.skin, eyes, template().lids)
