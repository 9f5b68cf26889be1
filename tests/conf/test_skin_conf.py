"""Skins from the command line become the renderer's."""

from dataclasses import replace

import pytest
from fakes.configurations import composed
from fakes.scenes import SKINS

from lrsr.errors import InputError
from lrsr.paths import config_folder
from lrsr.pictures.sitting import read_quality
from lrsr.rendering.skin import Skin

FOLDER = config_folder()


def skin(*overrides: str) -> Skin:
    return read_quality(composed("render", "out=x", *overrides)).skin


@pytest.mark.parametrize(
    "file", sorted(path.stem for path in (FOLDER / "rendering").glob("*.yaml"))
)
def test_every_rendering_has_the_skin_of_its_name(file: str) -> None:
    assert skin(f"rendering={file}") == SKINS[file]


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("jensen_skin1", "subsurface"),
        ("tone", "subsurface_tone"),
        ("reflective", "reflective"),
        ("volumetric", "volumetric"),
    ],
)
def test_every_skin_can_be_chosen_for_any_rendering(file: str, name: str) -> None:
    for rendering in ("subsurface", "reflective"):
        assert skin(f"rendering={rendering}", f"rendering/skin={file}") == SKINS[name]


def test_there_is_no_other_skin_file() -> None:
    files = {path.stem for path in (FOLDER / "rendering" / "skin").glob("*.yaml")}
    assert files == {"jensen_skin1", "tone", "reflective", "volumetric"}


def test_one_number_changes_one_number() -> None:
    changed = skin("rendering=subsurface", "rendering.skin.reach_mm=6")
    assert changed == replace(SKINS["subsurface"], reach_mm=6.0)
    traced = skin("rendering=volumetric", "rendering.skin.fixed=scattering")
    assert traced == SKINS["volumetric_tone"]


def test_a_number_out_of_range_names_the_setting() -> None:
    with pytest.raises(InputError, match=r"skin\.reach_mm=0"):
        skin("rendering=subsurface", "rendering.skin.reach_mm=0")
