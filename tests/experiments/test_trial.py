from dataclasses import replace
from pathlib import Path

import pytest
import torch
from fakes.painted import PaintedMaker
from skimage.metrics import peak_signal_noise_ratio

from lrsr.camera import Camera
from lrsr.camera.sensor import Sensor
from lrsr.experiments.conditions import Condition
from lrsr.experiments.design import Design
from lrsr.experiments.trial import Outcome, Trial
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.population import Population
from lrsr.identities.roster import IdentityRange, Roster, write_roster
from lrsr.images import luminance, resize_bicubic
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.picture import stack
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.render import take_pictures
from lrsr.pictures.sitting import Sitting
from lrsr.pictures.source import Rendered
from lrsr.presets import preset
from lrsr.recognition import Engine
from lrsr.rendering.scene import Film, Quality, Scene

METHODS = ("base", "bicubic2", "bicubic4", "srcnn2", "srcnn2x2", "srcnn4")
FRONTAL = Scene(preset("lighting", "frontal"))
QUALITY = Quality(samples_per_pixel=4, texture_size=64)
PEOPLE = IdentityRange(count=12)
DESIGN = Design(
    name="painted",
    question="Are painted people told apart?",
    conditions=(Condition(1, FRONTAL, "none", 8.0),),
    upscalers={name: preset("sr", name) for name in METHODS},
    people=PEOPLE,
    quality=QUALITY,
    seed=0,
    gallery=Sitting(PEOPLE, FRONTAL, Film(32.0), QUALITY, "gallery"),
    camera=Camera(),
)


def trial(folder: Path, model: Path, design: Design = DESIGN) -> Trial:
    cache = RenderCache(folder / "cache")
    return Trial(design, cache, Engine(model), PaintedMaker(), progress=False)


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory, tone_model: Path) -> Outcome:
    """What the design as it stands comes to."""
    (outcome,) = trial(tmp_path_factory.mktemp("plain"), tone_model).outcomes()
    return outcome


def recipes(source: object) -> list[Recipe]:
    assert isinstance(source, Rendered)
    return list(source.recipes)


def test_painted_people_are_told_apart_by_every_method(plain: Outcome) -> None:
    assert [row["method"] for row in plain.rows] == list(METHODS)
    assert all(row["auc"] > 0.99 for row in plain.rows)
    assert all((row["n_genuine"], row["n_impostor"]) == (12, 132) for row in plain.rows)


def test_everything_is_rendered_once_and_kept(tmp_path: Path, tone_model: Path) -> None:
    experiment = trial(tmp_path, tone_model)
    assert experiment.render() == 12 * (1 + 3)
    assert experiment.render() == 0
    assert trial(tmp_path, tone_model).render() == 0


def test_the_people_are_those_of_the_population_and_the_roster(
    tmp_path: Path, tone_model: Path
) -> None:
    redrawn = Roster("test", 0, 12, Population("female"), RECIPE_VERSION, "dlib", 11.2, {3: 2})
    roster = write_roster(tmp_path / "roster.json", redrawn)
    people = IdentityRange(count=12, sex="female", roster=str(roster))
    gallery = replace(DESIGN.gallery, people=people)
    experiment = trial(tmp_path, tone_model, replace(DESIGN, people=people, gallery=gallery))
    finest = experiment.references(DESIGN.conditions[0], 4)
    shown = [r.person for source in (experiment.gallery(), finest) for r in recipes(source)]
    assert {person.population for person in shown} == {Population("female")}
    assert [person.index for person in shown if person.draw == 2] == [3, 3]
    assert {person.draw for person in shown if person.index != 3} == {0}


def test_the_lens_is_that_of_the_probes_and_not_of_the_gallery(
    tmp_path: Path, tone_model: Path
) -> None:
    far = {"lens": preset("lens", "single"), "standpoint": preset("standpoint", "scface_far")}
    condition = replace(DESIGN.conditions[0], scene=replace(FRONTAL, **far))
    experiment = trial(tmp_path, tone_model, replace(DESIGN, conditions=(condition,)))
    for source in (experiment.probes(condition), experiment.references(condition, 4)):
        assert {(r.scene.lens, r.scene.standpoint) for r in recipes(source)} == {
            tuple(far.values())
        }
    assert {recipe.scene for recipe in recipes(experiment.gallery())} == {FRONTAL}


def test_a_probe_has_other_noise_than_its_gallery_picture(tmp_path: Path, tone_model: Path) -> None:
    experiment = trial(tmp_path, tone_model)
    (condition,) = DESIGN.conditions
    probes = experiment.probes(replace(condition, ipd_px=32.0))
    seeds = [recipe.seed for source in (experiment.gallery(), probes) for recipe in recipes(source)]
    assert len(set(seeds)) == 24


def test_psnr_is_measured_against_the_uncompressed_finer_film(
    tmp_path: Path, tone_model: Path
) -> None:
    heavy = replace(DESIGN.conditions[0], compression="heavy")
    bicubic = {"bicubic2": DESIGN.upscalers["bicubic2"]}
    asked = replace(DESIGN, conditions=(heavy,), upscalers=bicubic)
    experiment = trial(tmp_path, tone_model, asked)
    (outcome,) = experiment.outcomes()
    cache, maker = RenderCache(tmp_path / "cache"), PaintedMaker()
    film = [
        stack(take_pictures(recipes(source), cache, camera, maker=maker))[0]
        for source, camera in (
            (experiment.probes(heavy), Camera("heavy")),
            (experiment.references(heavy, 2), Camera("none")),
        )
    ]
    enlarged = luminance(resize_bicubic(film[0], 2).clamp(0, 1))[:, 0, 2:-2, 2:-2].double()
    true = luminance(film[1])[:, 0, 2:-2, 2:-2].double()
    each = [
        peak_signal_noise_ratio(a.numpy(), b.numpy(), data_range=1.0)
        for a, b in zip(true, enlarged, strict=True)
    ]
    assert outcome.rows[0]["psnr_y_db"] == pytest.approx(sum(each) / len(each), abs=1e-4)


def test_pictures_show_gallery_probe_methods_and_reference(plain: Outcome) -> None:
    assert list(plain.panel.pictures) == [
        "Gallery", "Probe", "Bicubic 2", "Bicubic 4", "SR 2", "SR 2x2", "SR 4", "Reference",
    ]  # fmt: skip
    assert plain.panel.pictures["Probe"].shape == (6, 3, 32, 32)
    assert plain.panel.pictures["Reference"].shape == (6, 3, 128, 128)
    assert all(torch.isfinite(images).all() for images in plain.panel.pictures.values())


def test_base_alone_needs_no_reference(tmp_path: Path, tone_model: Path) -> None:
    (outcome,) = trial(
        tmp_path, tone_model, replace(DESIGN, upscalers={"base": DESIGN.upscalers["base"]})
    ).outcomes()
    assert list(outcome.panel.pictures) == ["Gallery", "Probe"]
    assert outcome.rows[0]["psnr_y_db"] is None


def test_without_references_fewer_pictures_are_rendered_and_nothing_else_changes(
    plain: Outcome, tmp_path: Path, tone_model: Path
) -> None:
    without = trial(tmp_path, tone_model, replace(DESIGN, references=False))
    assert without.render() == 12 * 2
    (bare,) = without.outcomes()
    assert "Reference" not in bare.panel.pictures
    for row, full in zip(bare.rows, plain.rows, strict=True):
        assert row["psnr_y_db"] is row["identity_similarity"] is None
        assert row["auc"] == full["auc"]


def test_a_camera_with_flaws_takes_the_probes_alone(
    plain: Outcome, tmp_path: Path, tone_model: Path
) -> None:
    flawed = Camera(supersampling=2, sensor=Sensor(100.0), name="flawed")
    experiment = trial(tmp_path, tone_model, replace(DESIGN, camera=flawed))
    assert experiment.render() == 12 * (1 + 3)
    assert experiment.render() == 0
    (ours,) = experiment.outcomes()
    assert torch.equal(ours.panel.pictures["Gallery"], plain.panel.pictures["Gallery"])
    assert torch.equal(ours.panel.pictures["Reference"], plain.panel.pictures["Reference"])
    assert ours.panel.pictures["Probe"].shape == plain.panel.pictures["Probe"].shape
    assert not torch.equal(ours.panel.pictures["Probe"], plain.panel.pictures["Probe"])


def test_everybody_has_the_skin_of_the_condition(tmp_path: Path, tone_model: Path) -> None:
    skin = preset("rendering/skin", "tone")
    condition = replace(DESIGN.conditions[0], skin=skin)
    experiment = trial(tmp_path, tone_model)
    for source in (experiment.probes(condition), experiment.gallery(skin)):
        assert {recipe.quality.skin for recipe in recipes(source)} == {skin}
