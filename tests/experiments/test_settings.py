from dataclasses import replace
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from omegaconf import DictConfig

from lrsr.errors import InputError
from lrsr.experiments.settings import (
    Condition,
    GallerySettings,
    IdentityRange,
    RenderingSettings,
    section,
    verification_settings,
)
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.population import Population
from lrsr.identities.roster import Roster, write_roster
from lrsr.paths import config_folder
from lrsr.rendering.lens import find_lens
from lrsr.rendering.standpoint import find_standpoint


def composed(*overrides: str) -> DictConfig:
    with initialize_config_dir(str(config_folder()), version_base="1.3"):
        return compose("eval", list(overrides))


def test_eval_without_arguments_is_option_1_at_ipd_8_with_100_identities() -> None:
    settings = verification_settings(composed())
    assert settings.identities == IdentityRange("test", 0, 100)
    assert settings.conditions == (Condition(1, 8.0, "frontal", "frontal", "none"),)
    assert settings.rendering.samples_per_pixel == 512


def test_demo_has_24_identities_and_all_six_methods() -> None:
    with initialize_config_dir(str(config_folder()), version_base="1.3"):
        settings = verification_settings(compose("demo"))
    assert settings.identities.count == 24
    assert len(settings.methods) == 6


def test_probes_have_the_lens_and_the_standpoint_that_were_asked_for() -> None:
    settings = verification_settings(composed("lens=single", "standpoint=scface_far"))
    assert settings.lens == find_lens("single")
    assert settings.standpoint == find_standpoint("scface_far")
    assert verification_settings(composed()).lens == find_lens("pinhole")


def test_conditions_are_sizes_times_options() -> None:
    settings = verification_settings(composed("ipd_px=[8,11]", "options=[1,6]"))
    assert [(c.ipd_px, c.option) for c in settings.conditions] == [(8, 1), (8, 6), (11, 1), (11, 6)]
    assert settings.conditions[1].pose == "left"


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("options=[9]", r"options=9: wanted one of \[1, 2, 3, 4, 5, 6\]"),
        ("options=[]", "options"),
        ("methods=[]", "methods"),
        ("level=1.5", "level=1.5: wanted between 0 and 1"),
        ("level=high", "level=high"),
        ("seed=0.5", "seed=0.5: wanted a whole number"),
        ("ipd_px=2", "ipd_px=2.0: wanted at least 4"),
        ("ipd_px=wide", "ipd_px=wide"),
        ("identities.count=1", "identities.count=1: wanted at least 2"),
        ("identities.start=-1", "identities.start=-1"),
        ("identities.split=everyone", "identities.split=everyone"),
        ("identities.count=few", "identities.count"),
        ("identities.sex=woman", "identities.sex=woman: wanted one of any"),
        ("identities.ancestry=asian", r"identities.ancestry: wanted a list"),
        ("identities.ancestry=[martian]", r"identities.ancestry=\[martian\]"),
        ("identities.age_years=[12,30]", r"identities.age_years=\[12,30\]"),
        ("identities.roster=none.json", "cannot read none.json"),
        ("gallery.ipd_px=1", "gallery.ipd_px"),
        ("gallery.samples_per_pixel=0", "gallery.samples_per_pixel=0"),
        ("rendering.samples_per_pixel=0", "rendering.samples_per_pixel=0"),
    ],
)
def test_a_wrong_value_names_the_setting_and_the_remedy(override: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        verification_settings(composed(override))


@pytest.fixture
def roster(tmp_path: Path) -> Path:
    content = Roster("test", 0, 30, Population("female"), RECIPE_VERSION, "dlib", 11.2, {3: 2})
    return write_roster(tmp_path / "roster.json", content)


def test_a_roster_says_who_was_redrawn(roster: Path) -> None:
    words = [f"identities.roster={roster}", "identities/population=women", "identities.count=30"]
    people = verification_settings(composed(*words)).identities
    assert [people.cast.draw("test", index) for index in (2, 3, 4)] == [0, 2, 0]


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("identities.count=31", "covers test 0 to 29, not 30"),
        ("identities.sex=any", "another population: add identities.sex=female"),
        ("identities.split=train", "identities.split=train: wanted test, as the roster's"),
    ],
)
def test_a_roster_that_does_not_fit_is_refused(roster: Path, override: str, says: str) -> None:
    words = [f"identities.roster={roster}", "identities.sex=female", "identities.count=30"]
    with pytest.raises(InputError, match=says):
        verification_settings(composed(*words, override))


@pytest.mark.parametrize("option", ["everybody", "women", "men", "young", "elderly"])
def test_every_shipped_population_exists(option: str) -> None:
    people = verification_settings(composed(f"identities/population={option}")).identities
    assert (people.cast.population.tag == "") == (option == "everybody")


def test_an_unknown_compression_is_refused() -> None:
    with pytest.raises(InputError, match="compression=zip: wanted one of"):
        replace(Condition(1, 8.0, "frontal", "frontal", "none"), compression="zip")


@pytest.mark.parametrize(
    ("schema", "key"),
    [(IdentityRange, "identities"), (GallerySettings, "gallery"), (RenderingSettings, "rendering")],
)
def test_a_section_of_the_shipped_configuration_has_every_field(schema: type, key: str) -> None:
    assert isinstance(section(schema, composed(), key), schema)
