"""Tests of lrsr/experiments/systems.py, on tiles of tones in the place of faces."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import torch

from lrsr.errors import InputError
from lrsr.experiments.systems import Comparer, known_landmarks
from lrsr.pictures.picture import Picture
from lrsr.recognition import Engine
from lrsr.recognition.alignment import TEMPLATE_PX
from lrsr.sr import Bicubic


@dataclass
class Shelf:
    """Pictures of people; of ``lost`` nobody knows where the face is."""

    people: list[str]
    seed: int
    lost: tuple[int, ...] = ()

    @property
    def identity_ids(self) -> list[str]:
        return self.people

    @property
    def names(self) -> list[str]:
        return [f"{self.seed}-{k}.png" for k in range(len(self.people))]

    def load(self, start: int, stop: int) -> list[Picture]:
        points = torch.from_numpy(TEMPLATE_PX.astype(np.float32)) / 2
        return [
            Picture(
                torch.rand(3, 56, 56, generator=torch.Generator().manual_seed(100 * self.seed + k)),
                self.people[k],
                None if k in self.lost else points,
                "",
            )
            for k in range(start, stop)
        ]


@pytest.fixture
def comparer(tone_model: Path) -> Comparer:
    methods = {"base": Bicubic(1), "bicubic2": Bicubic(2)}
    return Comparer(methods, {"tones": Engine(tone_model)}, ("shared",), progress=False)


def test_scores_are_those_of_the_pictures_one_by_one(comparer: Comparer) -> None:
    probes, gallery = Shelf([*"abcdef"], 1), Shelf([*"abc"], 2)
    found = comparer.compare(probes, gallery, ipd_px=9)
    assert [one.name.method for one in found] == ["base", "bicubic2"]
    assert found[0].about == {
        "recogniser": "tones", "option": 1, "ipd_px": 9.0, "landmarks": "shared",
        "method": "base", "label": "Base",
    }  # fmt: skip
    engine = comparer.engines["tones"]
    for one, upscaler in zip(found, comparer.methods.values(), strict=True):
        (probe,), (enrolled,) = probes.load(4, 5), gallery.load(2, 3)
        assert probe.landmarks_px is not None
        assert enrolled.landmarks_px is not None
        points = upscaler.scale * (probe.landmarks_px + 0.5) - 0.5
        rows = [
            engine.embed(upscaler(probe.image[None]), points[None]),  # type: ignore[operator]  # it takes one picture
            engine.embed(enrolled.image[None], enrolled.landmarks_px[None]),
        ]
        score = one.system.source.rows(4, 5)[0, 2]
        assert score == pytest.approx(float(rows[0][0] @ rows[1][0]), abs=1e-5)


def test_what_was_not_acquired_is_named(comparer: Comparer) -> None:
    found = comparer.compare(Shelf([*"abcdef"], 1, lost=(0, 5)), Shelf([*"abc"], 2, lost=(1,)))
    for one in found:
        assert one.failures == (["1-0.png", "1-5.png"], ["2-1.png"])
        assert np.isnan(one.system.source.rows(0, 1)).all()


def test_landmarks_are_the_known_ones() -> None:
    assert known_landmarks(("shared", "own"), "x", known=True) == ("shared", "own")
    assert known_landmarks(("shared", "own"), "x", known=False) == ("own",)
    with pytest.raises(InputError, match="no picture in x has landmarks_px"):
        known_landmarks(("shared",), "x", known=False)
