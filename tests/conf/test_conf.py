"""Every shipped configuration composes, and stays short enough to read."""

from dataclasses import replace
from itertools import cycle, islice

import pytest
from fakes import configurations
from fakes.scenes import DAYS, EXPRESSIONS, LENSES, LIGHTINGS, POSES, ROOMS, STANDPOINTS
from omegaconf import OmegaConf

from lrsr.identities.face.expression import Expression
from lrsr.paths import config_folder
from lrsr.presets import preset, value_of
from lrsr.rendering.lens import Lens
from lrsr.rendering.pose import Pose

FOLDER = config_folder()
EXPERIMENTS = sorted(path.stem for path in (FOLDER / "experiment").glob("*.yaml"))
COMMANDS = ("demo", "eval", "fit-camera", "identities", "render", "train")


def composed(command: str, *overrides: str) -> dict[str, object]:
    plain = OmegaConf.to_container(configurations.composed(command, *overrides))
    assert isinstance(plain, dict)
    return {str(key): value for key, value in plain.items()}


@pytest.mark.parametrize("experiment", EXPERIMENTS)
def test_every_experiment_composes(experiment: str) -> None:
    assert composed("eval", f"experiment={experiment}")["name"] == experiment


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_a_configuration(command: str) -> None:
    assert "identities" in composed(command)


def test_a_file_says_what_it_is_and_stays_short() -> None:
    files = {file: file.read_text().splitlines() for file in FOLDER.rglob("*.yaml")}
    told = {file for file, lines in files.items() if any(one[:2] == "# " for one in lines[:2])}
    assert files.keys() - told == set(), "no first line that says what it is"
    assert {file for file, lines in files.items() if len(lines) > 40} == set()


def test_the_six_options_are_table_2_of_the_paper() -> None:
    table = composed("eval")["conditions"]
    assert isinstance(table, dict)
    assert {int(number): option for number, option in table.items()} == {
        1: {"compression": "none", "lighting": "frontal", "pose": "frontal"},
        2: {"compression": "none", "lighting": "above", "pose": "frontal"},
        3: {"compression": "none", "lighting": "above", "pose": "down"},
        4: {"compression": "heavy", "lighting": "frontal", "pose": "down"},
        5: {"compression": "heavy", "lighting": "below", "pose": "up"},
        6: {"compression": "heavy", "lighting": "below", "pose": "left"},
    }


CHOICES = {
    "pose": POSES,
    "lighting": (*LIGHTINGS, *ROOMS),
    "lens": LENSES,
    "standpoint": STANDPOINTS,
    "expression": EXPRESSIONS,
    "another_day": DAYS,
}
MOST = max(map(len, CHOICES.values()))


@pytest.mark.parametrize(
    "chosen",
    [*zip(*(islice(cycle(names), MOST) for names in CHOICES.values()), strict=True)],
    ids=" ".join,
)
def test_what_is_chosen_on_the_command_line_is_the_preset(chosen: tuple[str, ...]) -> None:
    words = [f"{group}={name}" for group, name in zip(CHOICES, chosen, strict=True)]
    config = OmegaConf.create(composed("render", *words))
    for group, name in zip(CHOICES, chosen, strict=True):
        assert value_of(group, config[group]) == preset(group, name)


def test_a_camera_can_be_chosen_for_experiments_too() -> None:
    assert OmegaConf.create(composed("eval", "camera=webcam")).camera.name == "webcam"


@pytest.mark.parametrize("name", LENSES)
def test_lenses_and_standpoints_are_for_every_command(name: str) -> None:
    config = OmegaConf.create(composed("eval", f"lens={name}", "standpoint=scface_far"))
    assert value_of("lens", config.lens) == LENSES[name]
    assert value_of("standpoint", config.standpoint) == STANDPOINTS["scface_far"]


@pytest.mark.parametrize("command", ["eval", "train"])
def test_expression_and_another_day_are_for_probes_and_training_too(command: str) -> None:
    given = ["expression=smile", "another_day=everything", "another_day.years=[1,2]"]
    config = OmegaConf.create(composed(command, *given))
    assert value_of("expression", config.expression) == EXPRESSIONS["smile"]
    day = value_of("another_day", config.another_day)
    assert day == replace(DAYS["everything"], years=(1, 2))


@pytest.mark.parametrize("name", sorted(path.stem for path in (FOLDER / "camera").glob("*.yaml")))
def test_every_camera_can_be_chosen_and_says_where_its_numbers_come_from(name: str) -> None:
    assert OmegaConf.create(composed("render", f"camera={name}")).camera.name == name
    text = (FOLDER / "camera" / f"{name}.yaml").read_text()
    assert name in {"reference", "ideal"} or "estimated" in text


def test_a_lens_and_a_standpoint_can_be_changed_on_the_command_line() -> None:
    given = ["lens=single", "lens.f_number=8", "standpoint=scface_near", "out=x"]
    config = OmegaConf.create(composed("render", *given, "standpoint.eye_height_m=1.7"))
    assert value_of("lens", config.lens) == replace(LENSES["single"], f_number=8.0)
    assert value_of("standpoint", config.standpoint).above_m == pytest.approx(0.55)


def test_face_units_can_be_given_on_the_command_line() -> None:
    given = ("+expression.units.jawOpen=0.2", "expression.strength=0.5", "expression=blink")
    config = OmegaConf.create(composed("render", "out=x", *given))
    units = {"eyeBlinkLeft": 0.5, "eyeBlinkRight": 0.5, "jawOpen": 0.1}
    assert value_of("expression", config.expression) == Expression("blink", units)


def test_what_a_file_says_in_its_first_lines_can_be_done() -> None:
    """The numbers that comments tell to change are there to be changed."""
    given = ["pose.yaw_deg=10", "pose.pitch_deg=-5", "pose.roll_deg=3", "lens=thin"]
    given += ["lens.f_number=2.8", "lens.focus_m=3", "standpoint.distance_m=3"]
    given += ["lighting=lamp", "lighting.panels.0.kelvin=2700", "lighting.fill_share=0.1"]
    config = OmegaConf.create(composed("render", "out=x", *given))
    assert value_of("pose", config.pose) == Pose("frontal", 10, -5, 3)
    assert value_of("lens", config.lens) == Lens("thin", f_number=2.8, focus_m=3)
    assert value_of("standpoint", config.standpoint).distance_m == 3
    assert value_of("lighting", config.lighting).panels[0].kelvin == 2700
