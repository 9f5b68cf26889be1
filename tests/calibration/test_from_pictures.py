"""``lrsr fit-camera`` from files to preset, with people made of paint."""

import html
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.painted import PaintedMaker
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lrsr.calibration import fit, from_pictures
from lrsr.calibration.fit import Fit, Fitted
from lrsr.calibration.from_pictures import FitSettings, fit_to_folder
from lrsr.calibration.parameters import PARAMETERS, lens_blur_px, with_jpeg, with_values
from lrsr.calibration.picture_statistics import BENT_NAMES
from lrsr.calibration.real_pictures import read_real_pictures
from lrsr.calibration.strangers import Strangers
from lrsr.camera.codec import jpeg
from lrsr.errors import ImageContractError, InputError
from lrsr.identities.person import Person
from lrsr.identities.roster import IdentityRange
from lrsr.paths import config_folder
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.image_files import write_png
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.sitting import Sitting
from lrsr.presets import preset
from lrsr.rendering.scene import Film, Quality, Scene

FRONTAL = Scene(preset("lighting", "frontal"))

HIDDEN = {
    "blur_px": 1.0,
    "sharpen_amount": 0.8,
    "read_noise": 0.02,
    "white_e": 3000.0,
    "exposure_ev": 0.0,
    "cast_red": 0.9,
    "cast_blue": 1.2,
    "contrast": 0.9,
    "saturation": 1.0,
}


def plain(path: Path) -> dict[str, Any]:
    values = OmegaConf.to_container(OmegaConf.load(path))
    assert isinstance(values, dict)
    return {str(key): value for key, value in values.items()}


def films(indices: range) -> Strangers:
    """Return painted people of the test split, whom the fit does not see."""
    maker, film, quality = PaintedMaker(), Film(scale=2), Quality()
    recipes = [Recipe(Person("test", k), FRONTAL, film, quality, seed=k) for k in indices]
    light = torch.stack([maker.render(maker.head(one), one).image for one in recipes])
    return Strangers(light, torch.ones(len(light)), 2, seed=500)


def strangers(count: int) -> Sitting:
    people = IdentityRange(split="train", count=count)
    return Sitting(people, FRONTAL, Film(), Quality(samples_per_pixel=4, texture_size=64))


def settings(images: Path, **changes: Any) -> FitSettings:
    return replace(
        FitSettings(
            images=images,
            preset=plain(config_folder() / "camera" / "generic.yaml"),
            strangers=strangers(24),
            name="lobby",
            part=1.0,
            rounds=2,
        ),
        **changes,
    )


@pytest.fixture(scope="module")
def hidden() -> Mapping[str, Any]:
    generic = plain(config_folder() / "camera" / "generic.yaml")
    return with_jpeg(with_values(generic, HIDDEN), 80, "4:2:0", (3, 5))


@pytest.fixture(scope="module")
def images(tmp_path_factory: pytest.TempPathFactory, hidden: Mapping[str, Any]) -> Path:
    folder = tmp_path_factory.mktemp("real")
    for k, picture in enumerate(films(range(30)).photographed(instantiate(hidden))):
        write_png(folder / f"{k:02d}.png", picture)
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, images: Path) -> Path:
    run = tmp_path_factory.mktemp("run")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fit, "_SETTLINGS", (1, 1))  # test_fit.py has a whole search
        return fit_to_folder(
            settings(images),
            run,
            cache=RenderCache(run / "cache"),
            maker=PaintedMaker(),
            progress=False,
        )


def test_the_preset_is_a_camera_like_the_hidden_one(
    folder: Path, hidden: Mapping[str, Any]
) -> None:
    fitted, camera = plain(folder / "lobby.yaml"), instantiate(hidden)
    found = instantiate(fitted)
    assert found.name == "lobby"
    assert lens_blur_px(found) == pytest.approx(lens_blur_px(camera), rel=0.2)
    assert found.stored.qualities == (80,)
    assert found.origin_px == (3, 5)
    red, green, blue = found.colour.white_balance
    true_red, true_green, true_blue = camera.colour.white_balance
    assert red / green == pytest.approx(true_red / true_green, rel=0.1)
    assert blue / green == pytest.approx(true_blue / true_green, rel=0.1)


def test_the_results_say_what_is_known_and_how_well(folder: Path) -> None:
    results = json.loads((folder / "results.json").read_text())
    assert results["pictures"] == 30
    assert results["misfit"]["after"] < 0.3 * results["misfit"]["before"]
    assert set(results["values"]) == set(HIDDEN)
    assert results["values"]["blur_px"]["known"]
    electrons, values = results["read_noise_e"], results["values"]
    assert electrons["value"] == pytest.approx(
        values["read_noise"]["value"] * values["white_e"]["value"]
    )
    assert electrons["low"] < electrons["value"] < electrons["high"]
    assert results["preset"] == plain(folder / "lobby.yaml")


def test_the_report_says_what_was_found_and_what_cannot_be(folder: Path) -> None:
    page = html.unescape((folder / "report.html").read_text())
    assert "JPEG quality 80, colours 4:2:0, grid from (5, 3) on, from the pixels." in page
    for sentence in (
        "The pictures are not compared one by one: nobody knows what they should look like.",
        "Exposure is known only together with the albedo of the people in the pictures",
        "Gain and full well cannot be told apart. What the codec removed is not known at all.",
        "every compression but the last are those of the camera that the search began with.",
        "Standard errors are of first order and hold if the rendered population",
    ):
        assert sentence in page
    assert page.count("<img") == 3 * 8 + 1
    assert (folder / "statistics.png").stat().st_size > 1000


class NoMaker(PaintedMaker):
    """Is never asked for anything."""

    def render(self, *_: Any) -> Any:
        raise AssertionError("something was rendered")


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"preset": "reference"}, "reference has no optics"),
        ({"preset": "nikon_d5100"}, "nikon_d5100 has measured colour filters"),
        ({"part": 0.3}, "their middle 0.3 is under 12 px"),
    ],
    ids=["no lens", "measured filters", "part"],
)
def test_what_cannot_be_fitted_is_refused_before_anything_is_rendered(
    changes: dict[str, Any], says: str, images: Path, tmp_path: Path
) -> None:
    if "preset" in changes:
        changes = {"preset": plain(config_folder() / "camera" / f"{changes['preset']}.yaml")}
    with pytest.raises((InputError, ImageContractError), match=says):
        fit_to_folder(
            settings(images, **changes),
            tmp_path,
            cache=RenderCache(tmp_path / "cache"),
            maker=NoMaker(),
            progress=False,
        )


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"strangers": strangers(19)}, "identities.count=19: wanted at least 20"),
        ({"rounds": 0}, "rounds=0: wanted at least 1"),
        ({"part": 0.0}, "part=0.0"),
        ({"ipd_px": 2.0}, "ipd_px=2.0: wanted at least 4"),
        ({"name": "../lobby"}, "name=../lobby: wanted letters"),
    ],
    ids=["people", "rounds", "part", "ipd", "name"],
)
def test_a_setting_out_of_range_is_refused(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        settings(Path("nowhere"), **changes)


def test_a_small_change_of_a_trial_changes_the_pictures_little() -> None:
    people = films(range(3))
    preset = with_jpeg(plain(config_folder() / "camera" / "generic.yaml"), None, "4:2:0", (0, 0))
    once = people.trial(with_values(preset, HIDDEN))
    again = people.trial(with_values(preset, HIDDEN | {"exposure_ev": 0.001}))
    other = Strangers(people.linear, people.metered, 2, seed=7).trial(with_values(preset, HIDDEN))
    assert (once - again).abs().mean() < 0.05 * (once - other).abs().mean()


def test_strangers_take_the_places_of_the_pictures_in_turn() -> None:
    people, generic = films(range(3)), plain(config_folder() / "camera" / "generic.yaml")
    presets = [with_jpeg(with_values(generic, HIDDEN), 30, "4:2:0", at) for at in ((0, 0), (3, 5))]
    first, second = (people.trial(preset) for preset in presets)
    both = people.trial(presets[0], origins_px=[(0, 0), (3, 5)])
    assert torch.equal(both, torch.stack([first[0], second[1], first[2]]))
    assert not torch.equal(first[1], second[1])


def test_the_file_follows_the_place_and_not_only_the_mosaic() -> None:
    people, generic = films(range(2)), plain(config_folder() / "camera" / "generic.yaml")
    preset = with_jpeg(with_values(generic, HIDDEN), 30, "4:2:0", (0, 0))
    before = people.trial({**preset, "stored": None})
    both = people.trial(preset, origins_px=[(0, 0), (4, 6)])
    assert torch.equal(both[1], jpeg(before[1:], 30, origin_px=(4, 6))[0])


def found(images: Path, *, known: bool, before: float, after: float) -> Fit:
    """Return a fit as if it had ended like that."""
    real = read_real_pictures(images, 20).srgb
    value = Fitted(1.0, 0.1, 0.8, 1.2, known=known)
    same = np.zeros(len(BENT_NAMES))
    doubts = np.eye(len(PARAMETERS))
    values = {one.name: value for one in PARAMETERS}
    assert len(real) == 30
    return Fit(values, PARAMETERS, doubts, same, same, same, same + 1, before, after, trials=1)


@pytest.mark.parametrize(
    ("outcome", "says"),
    [
        ({"known": False, "before": 9.0, "after": 1.0}, "they show nothing of the camera"),
        ({"known": True, "before": 1.1, "after": 1.3}, "the misfit has grown from 1.10 to 1.30"),
    ],
    ids=["guesses", "grown"],
)
def test_a_camera_of_no_use_is_reported_but_not_written(
    outcome: dict[str, Any],
    says: str,
    images: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told = found(images, **outcome)
    monkeypatch.setattr(from_pictures, "fit_camera", lambda *_, **__: told)
    with pytest.raises(InputError, match=rf"images=.*: {says}.*no preset.*report\.html\)"):
        fit_to_folder(
            settings(images),
            tmp_path,
            cache=RenderCache(tmp_path / "c"),
            maker=PaintedMaker(),
            progress=False,
        )
    assert not list(tmp_path.glob("*.yaml"))
    assert f"Not to be used: {says}" in html.unescape((tmp_path / "report.html").read_text())
    assert says in json.loads((tmp_path / "results.json").read_text())["refusal"]
