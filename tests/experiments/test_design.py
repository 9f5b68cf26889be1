from pathlib import Path

import pytest
from fakes import configurations
from omegaconf import DictConfig

from lrsr.errors import InputError
from lrsr.experiments.conditions import Condition
from lrsr.experiments.design import Design
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.population import Population
from lrsr.identities.roster import IdentityRange, Roster, write_roster
from lrsr.pictures.folder import Entry, write_manifest
from lrsr.presets import preset, presets
from lrsr.rendering.pose import Pose
from lrsr.rendering.scene import Scene


def composed(*overrides: str) -> DictConfig:
    return configurations.composed("eval", *overrides)


def test_eval_without_arguments_is_option_1_at_ipd_8_with_100_identities() -> None:
    settings = Design.from_config(composed())
    assert settings.people == IdentityRange(split="test", start=0, count=100)
    scene = Scene(preset("lighting", "frontal"), preset("pose", "frontal"))
    assert settings.conditions == (Condition(1, scene, "none", 8.0),)
    assert settings.quality.samples_per_pixel == 512


@pytest.mark.parametrize(
    ("word", "says"),
    [
        ("methods=[base,base]", r"methods=\['base', 'base'\]: wanted each of them once"),
        ("fusions=[mean,mean]", "fusions=.*: wanted each of them once"),
        ("options=[1,1]", r"options=\[1, 1\]: wanted each of them once"),
        ("ipd_px=[8,8.0]", r"ipd_px=\[8.0, 8.0\]: wanted each of them once"),
        ("ipd_px=[]", r"ipd_px=\[\]: wanted at least one size"),
        ("methods=[onnx]", r"sr\.onnx\.model must be given: add sr\.onnx\.model=\.\.\."),
    ],
)
def test_a_row_of_the_table_is_asked_for_once_and_wholly(word: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        Design.from_config(composed(word))


def test_demo_has_24_identities_and_all_six_methods() -> None:
    settings = Design.from_config(configurations.composed("demo"))
    assert settings.people.count == 24
    assert len(settings.upscalers) == 6


def test_probes_have_the_lens_and_the_standpoint_that_were_asked_for() -> None:
    settings = Design.from_config(composed("lens=single", "standpoint=scface_far"))
    (condition,) = settings.conditions
    assert condition.scene is not None
    assert condition.scene.lens == preset("lens", "single")
    assert condition.scene.standpoint == preset("standpoint", "scface_far")
    assert settings.gallery.scene.lens == preset("lens", "pinhole")


def test_probes_have_the_expression_and_the_day_that_were_asked_for_and_the_gallery_has_not() -> (
    None
):
    words = ["expression=smile", "another_day=glasses", "options=[1,2]"]
    settings = Design.from_config(composed(*words, "+conditions.2.another_day=cap"))
    first, second = (condition.scene for condition in settings.conditions)
    assert first is not None
    assert second is not None
    assert first.expression == second.expression == preset("expression", "smile")
    assert first.another_day == preset("another_day", "glasses")
    assert second.another_day == preset("another_day", "cap")
    assert settings.gallery.scene == Scene(preset("lighting", "frontal"))
    assert settings.conditions[0].title.endswith("compression none, smile, glasses")


def test_a_gallery_can_have_a_day_of_its_own() -> None:
    settings = Design.from_config(composed("gallery.another_day=cap", "gallery.expression=smile"))
    assert settings.gallery.scene.another_day == preset("another_day", "cap")
    assert settings.gallery.scene.expression == preset("expression", "smile")
    assert settings.conditions[0].scene == Scene(preset("lighting", "frontal"))


def test_the_experiment_of_another_day_has_every_kind_once() -> None:
    settings = Design.from_config(composed("experiment=another_day", "ipd_px=14"))
    days = [one.scene.another_day.name for one in settings.conditions if one.scene]
    assert sorted(days) == sorted(presets("another_day"))


def test_without_references_nobody_can_tell_how_far_pictures_are_from_them() -> None:
    assert not Design.from_config(composed("references=false")).references
    with pytest.raises(InputError, match="references=false: wanted true"):
        Design.from_config(composed("references=false", "lpips=mine.onnx"))


def test_conditions_are_sizes_times_options() -> None:
    settings = Design.from_config(composed("ipd_px=[8,11]", "options=[1,6]"))
    assert [(c.ipd_px, c.option) for c in settings.conditions] == [(8, 1), (8, 6), (11, 1), (11, 6)]
    assert settings.conditions[1].pose == "left"


@pytest.mark.parametrize(
    ("poses", "title"),
    [
        (("left", "left"), "Photographs, IPD 8 px: pose left, light below, compression heavy"),
        (("left", "up"), "Photographs, IPD 8 px: light below, compression heavy"),
    ],
)
def test_photographs_are_taken_as_their_manifest_says(
    poses: tuple[str, str], title: str, tmp_path: Path
) -> None:
    known = {"lighting": "below", "compression": "heavy", "ipd_px": 8.0}
    rows = [Entry(f"{k}.png", f"p{k}", pose=pose, **known) for k, pose in enumerate(poses)]
    for row in rows:
        (tmp_path / row.file).touch()
    write_manifest(tmp_path, rows)
    (condition,) = Design.from_config(composed(f"probes.folder={tmp_path}")).conditions
    assert condition.title == title
    assert condition.setting == "photographs"


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("options=[9]", r"options=9: wanted one of \[1, 2, 3, 4, 5, 6\]"),
        ("options=[]", "options"),
        ("methods=[]", "methods"),
        ("level=1.5", "level=1.5: wanted between 0 and 1"),
        ("level=high", "level=high"),
        ("seed=0.5", "seed=0.5: wanted a whole number"),
        ("ipd_px=2", "ipd_px=2: wanted at least 4"),
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
        Design.from_config(composed(override))


@pytest.fixture
def roster(tmp_path: Path) -> Path:
    content = Roster("test", 0, 30, Population("female"), RECIPE_VERSION, "dlib", 11.2, {3: 2})
    return write_roster(tmp_path / "roster.json", content)


def test_a_roster_says_who_was_redrawn(roster: Path) -> None:
    words = [f"identities.roster={roster}", "identities/population=women", "identities.count=30"]
    people = Design.from_config(composed(*words)).people
    assert [people.person(index).draw for index in (2, 3, 4)] == [0, 2, 0]


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
        Design.from_config(composed(*words, override))


@pytest.mark.parametrize("option", ["everybody", "women", "men", "young", "elderly"])
def test_every_shipped_population_exists(option: str) -> None:
    people = Design.from_config(composed(f"identities/population={option}")).people
    assert (people.cast.population.tag == "") == (option == "everybody")


def test_an_unknown_compression_is_refused() -> None:
    with pytest.raises(InputError, match="compression=zip: wanted one of"):
        Condition(1, Scene(preset("lighting", "above")), "zip", 8.0)


def test_a_condition_is_changed_and_added_on_its_own() -> None:
    words = ["conditions.1.pose=down", "+conditions.7={lighting: side}", "options=[1,7]"]
    one, seven = Design.from_config(composed(*words)).conditions
    assert (one.pose, one.lighting, one.compression) == ("down", "frontal", "none")
    assert (seven.option, seven.pose, seven.lighting) == (7, "frontal", "side")


def test_a_condition_may_have_angles_of_its_own() -> None:
    (condition,) = Design.from_config(composed("conditions.1.pose={yaw_deg: 12}")).conditions
    assert condition.scene is not None
    assert condition.scene.pose == Pose("own", yaw_deg=12.0)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["+conditions.1.jaw=3"], "conditions.1=jaw: wanted no such setting; there are pose"),
        (["conditions.1.pose=sideways"], "pose=sideways: there is none; choose one of"),
        (["conditions.1.pose=lefft"], "pose=lefft: there is none; did you mean left"),
        (["methods=[base,magic]"], "sr=magic: there is none"),
        (["+sr.mine.weights=x.ckpt"], "mine among them, as sr.mine is given"),
        (["recognition.landmarks=mine"], "landmarks=mine: wanted one of shared, own, both"),
        (["recognition.fallback=all"], "recognition.fallback=all: wanted one of none, whole_"),
        (["recognition.alignment=nose"], "recognition.alignment=nose: wanted one of arcface5"),
        (["recognition.enlargement.border=-1"], r"recognition\.enlargement\.border=-1"),
        (
            ["+recognition.enlargement.tile=3"],
            r"recognition\.enlargement=tile: wanted one of border",
        ),
        (["probes.folder=nowhere"], "nowhere is no folder"),
    ],
)
def test_what_nothing_would_read_is_refused(words: list[str], says: str) -> None:
    with pytest.raises(InputError, match=says):
        Design.from_config(composed(*words))
