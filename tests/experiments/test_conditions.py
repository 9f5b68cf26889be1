"""Every combination of some axes, each tested against the right one."""

from pathlib import Path

import pytest
from fakes import configurations
from omegaconf import OmegaConf

from lrsr.errors import InputError
from lrsr.experiments.conditions import Condition, photographed, read_conditions
from lrsr.pictures.source import read_photographs
from lrsr.presets import preset


def conditions(*words: str) -> dict[int, Condition]:
    return {one.option: one for one in read_conditions(configurations.composed("eval", *words))}


def test_the_sweep_is_the_papers_48_each_against_the_easiest() -> None:
    found = conditions("experiment=sweep")
    shown = [(one.pose, one.lighting, one.compression) for one in found.values()]
    assert len({*shown}) == len(shown) == 4 * 4 * 3
    assert (found[1].rival, shown[0]) == (None, ("frontal", "frontal", "none"))
    assert {found[number].rival for number in range(2, 49)} == {(1, 8.0)}
    assert found[48].title == "Option 48, IPD 8 px: pose left, lighting side, compression heavy"


def test_what_is_not_named_after_against_stays_equal() -> None:
    found = conditions("experiment=skin", "ipd_px=8")
    for one in found.values():
        assert one.skin is not None
        rival = found[one.rival[0]] if one.rival else None
        assert (rival is None) == (one.skin.name == "reflective")
        assert rival is None or rival.lighting == one.lighting
        assert rival is None or rival.skin == preset("rendering/skin", "reflective")


def test_an_axis_of_one_value_sets_nothing_apart() -> None:
    found = conditions("experiment=cameras", "+axes.pose=[left]", "axes.camera=[phone,webcam]")
    assert [one.setting for one in found.values()] == ["camera phone", "camera webcam"]
    assert {one.pose for one in found.values()} == {"left"}


def test_a_camera_may_be_a_file(tmp_path: Path) -> None:
    path = tmp_path / "lobby.yaml"
    path.write_text("_target_: lrsr.camera.Camera\nname: hall\nexposure_ev: 1.0\n")
    found = conditions("experiment=cameras", f"axes.camera=[phone,{path}]", "ipd_px=8")
    assert found[2].camera is not None
    assert (found[2].camera.name, found[2].camera.exposure_ev) == ("hall", 1.0)
    assert (found[2].setting, found[2].rival) == ("camera lobby", (1, 8.0))


def test_a_listed_condition_may_have_a_camera_of_its_own() -> None:
    (one,) = conditions("+conditions.1.camera=webcam").values()
    assert one.camera is not None
    assert one.camera.name == "webcam"
    assert (one.setting, one.rival) == ("", None)


def test_a_listed_condition_is_tested_against_itself_at_the_size_before() -> None:
    config = configurations.composed("eval", "ipd_px=[8,14,11]", "options=[1,2]")
    assert [(one.option, one.ipd_px, one.rival) for one in read_conditions(config)] == [
        *((1, 8.0, None), (2, 8.0, None)),
        *((1, 14.0, (1, 8.0)), (2, 14.0, (2, 8.0))),
        *((1, 11.0, (1, 14.0)), (2, 11.0, (2, 14.0))),
    ]


def test_options_choose_of_the_combinations() -> None:
    assert [*conditions("experiment=sweep", "options=[1,48]")] == [1, 48]
    with pytest.raises(InputError, match=r"options=49: wanted one of \[1, 2"):
        conditions("experiment=sweep", "options=[49]")


def test_a_condition_describes_itself_in_plain_values() -> None:
    told = conditions("experiment=cameras", "ipd_px=8")[2].describe()
    assert (told["camera"], told["varied"]) == ("generic", {"camera": "generic"})
    assert OmegaConf.to_container(OmegaConf.create(told))


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["+axes.jaw=[left]"], "axes=jaw: wanted some of pose, lighting"),
        (["axes.pose=up"], r"axes\.pose=up: wanted a list, e\.g\. axes\.pose=\[\.\.\.\]"),
        (["axes.pose=[true]"], "axes.pose=true: wanted a word"),
        (["axes.pose=[]"], r"axes\.pose=\[\]: wanted values, each once"),
        (["axes.pose=[up,up]"], r"axes\.pose=.*: wanted values, each once"),
        (["axes.pose=[upp]", "against=[]"], "pose=upp: there is none; did you mean up"),
        (["against=[camera]"], "against=camera: wanted some of the axes, pose, lighting, comp"),
        (
            ["+conditions={1: {pose: left}}"],
            "axes=pose, lighting, compression: wanted axes or condi",
        ),
        (["+axes.detector=[nobodys]"], "no detector 'nobodys'"),
        (["+axes.camera=[none.yaml]"], "none.yaml is missing"),
        (["+axes.camera=[fone]"], "camera=fone: there is none; did you mean phone"),
    ],
)
def test_what_cannot_be_gone_through_is_refused(words: list[str], says: str) -> None:
    with pytest.raises(InputError, match=says):
        conditions("experiment=sweep", *words)


def test_a_single_detector_is_no_comparison_of_detectors() -> None:
    wish = r"axes\.detector=\['shipped'\]: wanted two or more, to be compared; or against=\[\]"
    with pytest.raises(InputError, match=wish):
        conditions("experiment=detectors")
    assert len(conditions("experiment=detectors", "against=[]")) == 3
    assert len(conditions("experiment=detectors", "axes.detector=[shipped,x.onnx]")) == 6
    assert len(conditions("experiment=another_day", "axes.another_day=[hair]", "ipd_px=8")) == 1


def test_against_without_axes_is_refused() -> None:
    with pytest.raises(InputError, match=r"against=pose: wanted \[\], as there are no axes"):
        conditions("against=[pose]")


def test_photographs_are_looked_at_by_several_detectors_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "anna.png").touch()
    found = read_photographs(tmp_path, "probe")
    words = ["experiment=detectors", "~axes.compression", "axes.detector=[shipped,mine.onnx]"]
    one, other = photographed(configurations.composed("eval", *words), found)
    assert (one.detector, other.detector, other.setting) == (
        "shipped",
        "mine.onnx",
        "detector mine",
    )
    assert (one.rival, other.rival, one.scene) == (None, (1, None), None)
    with pytest.raises(InputError, match="axes=pose: wanted only a detector: photographs"):
        photographed(configurations.composed("eval", "experiment=sweep"), found)
