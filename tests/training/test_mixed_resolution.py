"""Tests of lrsr/training/mixed_resolution.py and of what it learns from."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fakes.painted import PaintedMaker

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.identities.person import Person
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.render import filmed
from lrsr.presets import preset
from lrsr.recognition.mixed_resolution import MixedResolution as Recogniser
from lrsr.recognition.mixed_resolution import _side_px
from lrsr.rendering.lens import PINHOLE
from lrsr.rendering.pose import FRONTAL
from lrsr.rendering.scene import Quality
from lrsr.rendering.standpoint import LEVEL
from lrsr.training.encounters import Encounters
from lrsr.training.mixed_resolution import MixedResolution


def encounters(cache: RenderCache, **changes: Any) -> Encounters:
    lightings = [preset("lighting", name) for name in ("frontal", "above")]
    given: dict[str, Any] = {
        "people": [Person("train", index) for index in range(30)],
        "validation_people": [Person("validation", index) for index in range(10)],
        "poses": [FRONTAL],
        "lightings": lightings,
        "compressions": ["none", "heavy"],
        "views": 2,
        "probe_ipd_px": 8,
        "gallery_lighting": lightings[0],
        "gallery_ipd_px": 16,
        "gallery_samples": 16,
        "lens": PINHOLE,
        "standpoint": LEVEL,
        "quality": Quality(96),
        "camera": Camera(),
        "seed": 0,
        "maker": PaintedMaker(),
        "progress": False,
    }
    return Encounters(cache=cache, **{**given, **changes})


def learn(folder: Path, data: Encounters, **changes: Any) -> Path:
    folder.mkdir(exist_ok=True)
    module = MixedResolution(components=[5, 10, 40], dimensions=[5, 10], seed=0)
    return module.train(data, folder=folder, **{"depends_on": {"seed": 0}, **changes})


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("mixed")
    return learn(folder / "run", encounters(RenderCache(folder / "cache")))


def test_either_side_has_its_own_pixels_and_every_probe_its_owner(cache: RenderCache) -> None:
    data = encounters(cache)
    data.prepare_data()
    data.setup()
    met = data.training
    assert met.probes.shape == (30 * 2 * 2, _side_px(8) ** 2)
    assert met.gallery.shape == (30, _side_px(16) ** 2)
    first = data.probes(data.people)
    assert [recipe.person.index for recipe in first] == met.people[:60].tolist()
    assert np.bincount(met.people).tolist() == [4] * 30
    assert len(data.validation.gallery) == 10


def test_everything_is_rendered_beforehand(cache: RenderCache) -> None:
    data = encounters(cache)
    assert len({filmed(*shot) for shot in data.shots()}) == 40 * (1 + 2)


def test_what_people_share_is_found_and_recognises_others(run: Path) -> None:
    told = json.loads((run / "metrics.json").read_text())
    assert told["finished"]
    assert told["best"]["val/auc"] > 0.99
    assert told["best"]["val/auc"] == max(one["val/auc"] for one in told["history"])
    tried = [(one["components"], one["dimension"]) for one in told["history"]]
    assert tried == [(5, 5), (10, 5), (10, 10)]  # 30 people do not suffice for 40
    assert told["settings"] == {"seed": 0}


def test_weights_say_what_they_serve(run: Path) -> None:
    about = Recogniser(run / "model.safetensors").describe()
    assert (about["probe_ipd_px"], about["gallery_ipd_px"], about["people"]) == (8.0, 16.0, 30)
    assert "lights frontal, above; compressions none, heavy; skin" in str(about["scene"])
    told = json.loads((run / "metrics.json").read_text())
    assert about["sha256"] == told["model_sha256"]
    assert about["dimension"] == told["best"]["dimension"]


def test_the_same_run_gives_the_same_bytes(run: Path, tmp_path: Path) -> None:
    again = learn(tmp_path / "again", encounters(RenderCache(run.parent / "cache")))
    name = "model.safetensors"
    assert (again / name).read_bytes() == (run / name).read_bytes()


def test_the_folder_of_another_run_is_left_alone(run: Path) -> None:
    before = (run / "metrics.json").read_bytes()
    data = encounters(RenderCache(run.parent / "cache"))
    with pytest.raises(InputError, match="was trained with seed=0"):
        learn(run, data, depends_on={"seed": 1})
    assert (run / "metrics.json").read_bytes() == before


def test_too_few_people_are_refused(tmp_path: Path) -> None:
    few = [Person("train", index) for index in range(5)]
    with pytest.raises(InputError, match="5 people suffice for none"):
        learn(tmp_path / "run", encounters(RenderCache(tmp_path / "cache"), people=few))
    assert not (tmp_path / "cache").exists()  # nothing was rendered for that


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"probe_ipd_px": 2}, "data.probe_ipd_px=2.0: wanted 4 to 35"),
        ({"gallery_ipd_px": "x"}, "data.gallery_ipd_px=x: wanted a number"),
        ({"views": 3}, "data.views=3: wanted 1 to 2"),
        ({"poses": []}, "at least one of each"),
        ({"compressions": []}, "data.compressions"),
        ({"gallery_samples": 0}, "data.gallery_samples=0"),
    ],
)
def test_values_out_of_range_are_refused(
    cache: RenderCache, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        encounters(cache, **changes)


@pytest.mark.parametrize("given", [{"components": []}, {"dimensions": [0]}])
def test_there_must_be_sizes_to_try(given: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="whole numbers from 1 on"):
        MixedResolution(**{"components": [5], "dimensions": [5], **given})
    with pytest.raises(InputError, match=r"module\.parts=1: wanted at least 2"):
        MixedResolution([5], [5], parts=1)
    with pytest.raises(InputError, match=r"module\.dimensions=\[10\]: wanted one of 5 at most"):
        MixedResolution([5], [10])
