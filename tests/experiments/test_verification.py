from dataclasses import replace
from pathlib import Path

import pytest
import torch
from fakes.painted import PaintedMaker
from skimage.metrics import peak_signal_noise_ratio

from lrsr.camera import Camera
from lrsr.camera.sensor import Sensor
from lrsr.data.cache import RenderCache
from lrsr.data.probes import load_probes, stack
from lrsr.errors import InputError
from lrsr.experiments.settings import (
    Condition,
    GallerySettings,
    IdentityRange,
    RenderingSettings,
    VerificationSettings,
)
from lrsr.experiments.verification import Verification
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.population import Population
from lrsr.identities.roster import Roster, write_roster
from lrsr.images import luminance, resize_bicubic
from lrsr.recognition import Engine

SETTINGS = VerificationSettings(
    name="painted",
    question="Are painted people told apart?",
    conditions=(Condition(1, 8.0, "frontal", "frontal", "none"),),
    methods=("base", "bicubic2", "bicubic4", "srcnn2", "srcnn2x2", "srcnn4"),
    identities=IdentityRange(count=12),
    gallery=GallerySettings(ipd_px=32.0),
    rendering=RenderingSettings(samples_per_pixel=4, texture_size=8),
    seed=0,
    level=0.95,
)


def trial(folder: Path, model: Path, settings: VerificationSettings = SETTINGS) -> Verification:
    cache = RenderCache(folder / "cache")
    return Verification(settings, cache, Engine(model), Camera(), PaintedMaker())


def test_painted_people_are_told_apart_by_every_method(tmp_path: Path, tone_model: Path) -> None:
    (outcome,) = trial(tmp_path, tone_model).outcomes()
    assert [row.method for row in outcome.rows] == list(SETTINGS.methods)
    assert all(row.auc > 0.99 for row in outcome.rows)
    assert all((row.n_genuine, row.n_impostor) == (12, 132) for row in outcome.rows)


def test_everything_is_rendered_once_and_kept(tmp_path: Path, tone_model: Path) -> None:
    experiment = trial(tmp_path, tone_model)
    assert experiment.render(progress=False) == 12 * (1 + 3)
    assert experiment.render(progress=False) == 0
    assert trial(tmp_path, tone_model).render(progress=False) == 0


def test_the_people_are_those_of_the_population_and_the_roster(
    tmp_path: Path, tone_model: Path
) -> None:
    redrawn = Roster("test", 0, 12, Population("female"), RECIPE_VERSION, "dlib", 11.2, {3: 2})
    roster = write_roster(tmp_path / "roster.json", redrawn)
    people = IdentityRange(count=12, sex="female", roster=str(roster))
    experiment = trial(tmp_path, tone_model, replace(SETTINGS, identities=people))
    recipes = [
        *experiment.gallery_recipes(),
        *experiment.probe_recipes(SETTINGS.conditions[0], 4),
    ]
    assert {recipe.population for recipe in recipes} == {Population("female")}
    assert [recipe.index for recipe in recipes if recipe.draw == 2] == [3, 3]
    assert {recipe.draw for recipe in recipes if recipe.index != 3} == {0}


def test_the_lens_is_that_of_the_probes_and_not_of_the_gallery(
    tmp_path: Path, tone_model: Path
) -> None:
    settings = replace(SETTINGS, lens="single", standpoint="scface_far")
    experiment = trial(tmp_path, tone_model, settings)
    probes = experiment.probe_recipes(SETTINGS.conditions[0], 4)
    assert {(recipe.lens, recipe.standpoint) for recipe in probes} == {("single", "scface_far")}
    gallery = experiment.gallery_recipes()
    assert {(recipe.lens, recipe.standpoint) for recipe in gallery} == {("pinhole", "level")}


def test_a_probe_has_other_noise_than_its_gallery_picture(tmp_path: Path, tone_model: Path) -> None:
    experiment = trial(tmp_path, tone_model)
    (condition,) = SETTINGS.conditions
    probes = experiment.probe_recipes(replace(condition, ipd_px=32.0), 1)
    seeds = [recipe.seed for recipe in (*experiment.gallery_recipes(), *probes)]
    assert len(set(seeds)) == 24


def test_psnr_is_measured_against_the_uncompressed_finer_film(
    tmp_path: Path, tone_model: Path
) -> None:
    heavy = replace(SETTINGS.conditions[0], compression="heavy")
    experiment = trial(
        tmp_path, tone_model, replace(SETTINGS, conditions=(heavy,), methods=("bicubic2",))
    )
    (outcome,) = experiment.outcomes()
    cache, maker = RenderCache(tmp_path / "cache"), PaintedMaker()
    film = [
        stack(load_probes(experiment.probe_recipes(heavy, scale), cache, camera, maker=maker))[0]
        for scale, camera in ((1, Camera("heavy")), (2, Camera("none")))
    ]
    enlarged = luminance(resize_bicubic(film[0], 2).clamp(0, 1))[:, 0, 2:-2, 2:-2].double()
    true = luminance(film[1])[:, 0, 2:-2, 2:-2].double()
    each = [
        peak_signal_noise_ratio(a.numpy(), b.numpy(), data_range=1.0)
        for a, b in zip(true, enlarged, strict=True)
    ]
    assert outcome.rows[0].psnr_y_db == pytest.approx(sum(each) / len(each), abs=1e-4)


def test_pictures_show_gallery_probe_methods_and_reference(
    tmp_path: Path, tone_model: Path
) -> None:
    (outcome,) = trial(tmp_path, tone_model).outcomes()
    assert list(outcome.pictures) == [
        "Gallery", "Probe", "Bicubic 2", "Bicubic 4", "SR 2", "SR 2x2", "SR 4", "Reference",
    ]  # fmt: skip
    assert outcome.pictures["Probe"].shape == (6, 3, 32, 32)
    assert outcome.pictures["Reference"].shape == (6, 3, 128, 128)
    assert all(torch.isfinite(images).all() for images in outcome.pictures.values())


def test_base_alone_needs_no_reference(tmp_path: Path, tone_model: Path) -> None:
    (outcome,) = trial(tmp_path, tone_model, replace(SETTINGS, methods=("base",))).outcomes()
    assert list(outcome.pictures) == ["Gallery", "Probe"]
    assert outcome.rows[0].psnr_y_db is None


def test_an_unknown_method_is_refused_before_rendering(tmp_path: Path, tone_model: Path) -> None:
    with pytest.raises(InputError, match="magic"):
        trial(tmp_path, tone_model, replace(SETTINGS, methods=("magic",)))


def test_a_camera_with_flaws_takes_the_probes_alone(tmp_path: Path, tone_model: Path) -> None:
    flawed = Camera(supersampling=2, sensor=Sensor(100.0), name="flawed")
    cache = RenderCache(tmp_path / "cache")
    experiment = Verification(SETTINGS, cache, Engine(tone_model), flawed, PaintedMaker())
    assert experiment.render(progress=False) == 12 * (1 + 3)
    assert experiment.render(progress=False) == 0
    (ours,) = experiment.outcomes()
    (plain,) = trial(tmp_path, tone_model).outcomes()
    assert torch.equal(ours.pictures["Gallery"], plain.pictures["Gallery"])
    assert torch.equal(ours.pictures["Reference"], plain.pictures["Reference"])
    assert ours.pictures["Probe"].shape == plain.pictures["Probe"].shape
    assert not torch.equal(ours.pictures["Probe"], plain.pictures["Probe"])
