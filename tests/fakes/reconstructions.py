"""Faces that are found on every picture and reconstructed in no time."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fakes.sets import points_of

from lrsr.experiments import intake
from lrsr.identities.photographs.person import Photographed
from lrsr.identities.photographs.quality import Quality
from lrsr.recognition.detection.faces import Detection

_GOOD = Quality(32.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.5, 0.8, 40.0, 0.6, 0.1, (0.0, 0.0))


@contextmanager
def pretended(glasses: str) -> Iterator[list[str]]:
    """Pretend, and give the stems of the files that were reconstructed.

    Args:
        glasses: Stem of the file on which somebody wears them.
    """
    made: list[str] = []

    def reconstruct(person: Photographed, _: int) -> SimpleNamespace:
        made.append(name := Path(person.file).stem)
        return SimpleNamespace(
            quality=replace(_GOOD, glasses_edge=300.0) if name == glasses else _GOOD
        )

    face = Detection(np.zeros(4, np.float32), 1.0, points_of(32, 96).astype(np.float32))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(intake, "portrait_faces", lambda *_: [face])
        patch.setattr(Photographed, "reconstruction", reconstruct)
        yield made
