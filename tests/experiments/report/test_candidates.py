"""Tests of lrsr/experiments/report/candidates.py."""

import base64
import io
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from PIL import Image

from lrsr.experiments.report.candidates import shown_candidates
from lrsr.pictures.picture import Picture


@dataclass
class Shelf:
    names: list[str]
    side: int = 8

    def load(self, start: int, stop: int) -> list[Picture]:
        level = [k / len(self.names) for k in range(start, stop)]
        images = [torch.full((3, self.side, self.side), one) for one in level]
        return [Picture(image, "p", None, "") for image in images]


def hit(probe: str, rank: int, gallery: str) -> dict[str, Any]:
    about = {"recogniser": "r", "label": "Base", "landmarks": "own"}
    return {**about, "probe": probe, "rank": rank, "gallery": gallery, "score": 0.5}


def test_every_picture_is_there_once_under_the_name_of_its_style() -> None:
    hits = [hit("b", 1, "y"), hit("b", 2, "x"), hit("a", 1, "y")]
    shown = shown_candidates(hits, Shelf(["a", "b", "c"]), Shelf(["x", "y", "z"]))
    assert shown["style"] == {"probe": {"a": "p0", "b": "p1"}, "gallery": {"x": "g0", "y": "g1"}}
    assert [*shown["lists"]["r, Base, own landmarks"]] == ["b", "a"]
    assert {*shown["thumbs"]} == {"p0", "p1", "g0", "g1"}
    pixels = np.asarray(Image.open(io.BytesIO(
        base64.b64decode(shown["thumbs"]["g1"].partition(",")[2]))))  # fmt: skip
    assert (pixels == 85).all()  # a third


def test_large_pictures_are_shrunk_and_long_lists_cut() -> None:
    names = [f"{k}" for k in range(50)]
    shown = shown_candidates([hit(name, 1, "x") for name in names], Shelf(names), Shelf(["x"], 400))
    assert shown["n_probes"] == 50
    assert len(shown["lists"]["r, Base, own landmarks"]) == 40
    content = base64.b64decode(shown["thumbs"]["g0"].partition(",")[2])
    assert Image.open(io.BytesIO(content)).size == (100, 100)
