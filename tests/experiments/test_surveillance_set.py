"""Tests of lrsr/experiments/surveillance_set.py and three of its studies, on made-up copies."""

import json
from pathlib import Path
from typing import Any

import pytest
import torch
from fakes.configurations import composed
from fakes.sets import write_ijb, write_survface, write_tinyface

from lrsr.errors import InputError
from lrsr.experiments.ijb_study import IjbStudy
from lrsr.experiments.survface_study import SurvFaceStudy
from lrsr.experiments.tinyface_study import TinyFaceStudy
from lrsr.pictures.cache import RenderCache
from lrsr.sr.upscaler import OneStep

LOOKED_AT = (("1", "probe"), ("1", "gallery"), ("2", "gallery"))
STUDIES = {"tinyface": TinyFaceStudy, "survface": SurvFaceStudy, "ijb": IjbStudy}


def run(folder: Path, name: str, *words: str) -> tuple[dict[str, Any], str]:
    config = composed("eval", f"experiment={name}", "methods=[base]", *words)
    asked = STUDIES[name].from_config(config)  # type: ignore[attr-defined]  # both have it
    place = asked.run(folder / "run", RenderCache(folder / "cache"), progress=False)
    return json.loads((place / "results.json").read_text()), (place / "report.html").read_text()


def test_tinyface_is_a_search_among_distractors(tmp_path: Path, tone_model: Path) -> None:
    root = write_tinyface(tmp_path / "set", people=3, distractors=2)
    words = (f"tinyface.root={root}", f"recognition.model={tone_model}")
    results, page = run(tmp_path, "tinyface", *words)
    (found,) = results["searches"]
    assert (found["n_mated"], found["n_unmated"], found["n_gallery"]) == (3, 0, 8)
    assert [hit["rank"] for hit in found["hits"]] == [1, 5, 10, 20]
    assert [hit["rate"] for hit in found["hits"]] == [1, 1, 1, 1]
    assert found["open_set"] == []
    (row,) = results["rows"]
    assert (row["setting"], row["fta"], row["landmarks"]) == ("TinyFace", 0, "own")
    assert (row["n_genuine"], row["n_impostor"]) == (6, 18)
    for words_told in ("Identification", "Rank 20", "the whole picture stood for it"):
        assert words_told in page
    assert "A threshold set on other people" not in page
    assert results["config"]["tinyface"] == {"root": str(root), "distractors": None}
    assert not (tmp_path / "run" / "scores.csv").exists()
    assert "<h1>TinyFace</h1>" in page
    assert "beside the truth" not in page  # nobody knows it


def test_survface_has_listed_pairs_and_an_open_set(tmp_path: Path, tone_model: Path) -> None:
    root = write_survface(tmp_path / "set", people=3, strangers=2)
    words = ("survface.protocols=[verification,identification]", f"recognition.model={tone_model}")
    results, page = run(tmp_path, "survface", f"survface.root={root}", *words)
    pairs, search = results["rows"]
    assert (pairs["n_genuine"], pairs["n_impostor"], pairs["rank_1"]) == (3, 3, None)
    assert (search["n_genuine"], search["n_impostor"]) == (3, 3 * 2 + 2 * 3)  # three templates
    (found,) = results["searches"]
    assert (found["n_mated"], found["n_unmated"], found["n_gallery"]) == (3, 2, 3)
    assert [point["target_fpir"] for point in found["open_set"]] == [0.3, 0.2, 0.1, 0.01]
    assert found["open_set"][0]["tpir"] == 1
    for told in ("TPIR20", "one template, the mean of embeddings", "QMUL-SurvFace, verification"):
        assert told in page


def test_ijb_compares_templates_with_each_gallery(
    tmp_path: Path, tone_model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    enlarged: list[int] = []
    enlarge = OneStep.__call__

    def count(self: OneStep, srgb: torch.Tensor) -> torch.Tensor:
        enlarged.append(len(srgb))
        return enlarge(self, srgb)

    monkeypatch.setattr(OneStep, "__call__", count)
    root = write_ijb(tmp_path / "set")
    lists = "ijb.galleries=[protocols/gallery_S1.csv,protocols/gallery_S2.csv]"
    words = (lists, "ijb.probes=protocols/probe.csv", f"recognition.model={tone_model}")
    results, page = run(tmp_path, "ijb", f"ijb.root={root}", "ijb.margin=0", *words)
    assert [row["setting"] for row in results["rows"]] == ["IJB, gallery_S1", "IJB, gallery_S2"]
    for row, found in zip(results["rows"], results["searches"], strict=True):
        assert (row["n_genuine"], row["n_impostor"], row["auc"]) == (2, 6, 1)
        assert (found["n_mated"], found["n_unmated"], found["n_gallery"]) == (2, 2, 2)
        assert (found["hits"][0]["rate"], found["open_set"][-1]["tpir"]) == (1, 1)
    pictures = [results["config"]["parts"][k][f"{kind}_pictures"] for k, kind in LOOKED_AT]
    assert pictures[0] == 12
    assert sum(enlarged) == sum(pictures)  # the probes once, not once a gallery
    for told in ("the mean of the embeddings of its media", "lists of pairs", "gallery_S2"):
        assert told in page


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([], r"ijb\.probes=null: wanted a CSV file of the set"),
        (["ijb.probes=p.csv"], r"ijb\.galleries=\[\]: wanted CSV files"),
        (["ijb.margin=-1"], r"ijb\.margin=-1"),
        (["ijb.frames=0"], r"ijb\.frames=0"),
    ],
    ids=["probes", "galleries", "margin", "frames"],
)
def test_what_ijb_needs_must_be_given(tmp_path: Path, words: list[str], told: str) -> None:
    with pytest.raises(InputError, match=told):
        run(tmp_path, "ijb", f"ijb.root={tmp_path}", *words)


@pytest.mark.parametrize("name", [*STUDIES])
def test_a_copy_must_be_given(tmp_path: Path, name: str) -> None:
    told = rf"{name}\.root=null: wanted {name}\.root=DIR, your copy; \S+ has it"
    with pytest.raises(InputError, match=told):
        run(tmp_path, name)


@pytest.mark.parametrize("protocols", ["[]", "[training]"])
def test_a_protocol_that_is_none_is_refused(tmp_path: Path, protocols: str) -> None:
    with pytest.raises(InputError, match="some of verification, identification"):
        run(tmp_path, "survface", f"survface.protocols={protocols}")
