"""Tests of lrsr/experiments/simulation.py, without rendering anybody."""

from pathlib import Path

import pytest
from fakes.configurations import composed

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.evaluation.likelihood import split_ids
from lrsr.experiments.simulation import Simulation, read_generic
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.sitting import read_gallery, read_probes
from lrsr.rendering.scene import Film


@pytest.fixture
def simulation(tmp_path: Path) -> Simulation:
    config = composed("eval", "experiment=case", "identities.count=20", "ipd_px=9", "pose=up")
    probes = read_probes(config, Film(9.0))
    generic = read_generic(config, probes)
    cache = RenderCache(tmp_path)
    return Simulation(probes, read_gallery(config), Camera(compression="heavy"), generic, cache)


def test_everybody_is_pictured_as_in_the_case(simulation: Simulation) -> None:
    seen = simulation.seen
    assert len(seen.recipes) == 20
    assert {(r.scene.pose.name, r.film.ipd_px) for r in seen.recipes} == {("up", 9.0)}
    assert seen.camera.compression == "heavy"
    assert (simulation.enrolled.camera.compression, simulation.enrolled.camera.flawless) == (
        "none",
        True,
    )


@pytest.mark.parametrize("name", ["good", "mixed"])
def test_only_those_who_are_calibrated_on_are_pictured_otherwise(
    simulation: Simulation, name: str
) -> None:
    learn, judge = split_ids(simulation.seen.identity_ids, 0)
    people = simulation.generic_probes(name).identity_ids
    assert {*people} == {*learn}
    assert not {*people} & {*judge}


def test_ways_to_picture_people_take_turns(simulation: Simulation) -> None:
    recipes = simulation.generic_probes("mixed").recipes
    assert [r.film.ipd_px for r in recipes[:4]] == [32, 24, 16, 32]
    assert [r.scene.pose.name for r in recipes[:3]] == ["frontal", "left", "down"]
    assert {r.scene.expression.name for r in recipes} == {"neutral"}


def test_a_way_that_nobody_can_be_pictured_in_is_refused() -> None:
    config = composed("eval", "experiment=case", "generic.good=[{ipd_px: 3}]")
    with pytest.raises(InputError, match=r"generic\.good\.0\.ipd_px=3\.0: wanted at least 4"):
        read_generic(config, read_probes(config, Film(9.0)))
