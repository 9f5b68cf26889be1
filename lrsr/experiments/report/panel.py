"""What is shown of one condition? Its curves, its faces and further figures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import torch

from lrsr.evaluation.roc import RocCurve


@dataclass(frozen=True)
class Figure:
    """A picture of a report.

    Attributes:
        image: As a data URI.
        alt: What it shows, for who cannot see it.
        caption: What a reader must know.
    """

    image: str
    alt: str
    caption: str


@dataclass(frozen=True)
class Panel:
    """What one condition looks like.

    Attributes:
        title: Names the condition.
        curves: ROC curves by the source of the landmarks and by method label, in the order of the
            legend; may be empty.
        pictures: Columns of the contact sheet in order, e.g. Gallery, Probe, each method,
            Reference; each ``(n, 3, h, w)`` srgb in [0, 1], any size; may be empty.
        people: Names of the n people shown.
        figures: Shown below the ROC curves.
        place: Option and size of the condition, where it has them.
    """

    title: str
    curves: Mapping[str, Mapping[str, RocCurve]] = field(default_factory=dict)
    pictures: Mapping[str, torch.Tensor] = field(default_factory=dict)
    people: Sequence[str] = ()
    figures: Sequence[Figure] = ()
    place: tuple[int, float | None] | None = None
