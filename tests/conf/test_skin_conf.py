"""Skins from the command line become the renderer's."""

import pytest
from hydra import compose, initialize_config_dir
from lrsr.experiments.settings import RenderingSettings

from lrsr.configuration import section
from lrsr.errors import InputError
from lrsr.paths import config_folder
from lrsr.rendering.skin import SKINS, Skin

FOLDER = config_folder()


def settings(*overrides: str) -> RenderingSettings:
    with initialize_config_dir(str(FOLDER), version_base="1.3"):
        return section(RenderingSettings, compose("render", ["out=x", *overrides]), "rendering")


@pytest.mark.parametrize(
    "file", sorted(path.stem for path in (FOLDER / "rendering").glob("*.yaml"))
)
def test_every_rendering_has_the_skin_of_its_name(file: str) -> None:
    assert settings(f"rendering={file}").skin == file


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("jensen_skin1", "subsurface"),
        ("tone", "subsurface_tone"),
        ("reflective", "reflective"),
        ("volumetric", "volumetric"),
    ],
)
def test_every_skin_file_is_a_skin_with_a_name(file: str, name: str) -> None:
    assert settings("rendering=subsurface", f"rendering/skin={file}").skin == name
    assert name in SKINS


def test_there_is_no_other_skin_file() -> None:
    files = {path.stem for path in (FOLDER / "rendering" / "skin").glob("*.yaml")}
    assert files == {"jensen_skin1", "tone", "reflective", "volumetric"}


def test_one_number_changes_one_number() -> None:
    changed = settings("rendering=subsurface", "rendering.skin.reach_mm=6").skin
    assert changed == Skin(reach_mm=6.0)


def test_a_number_out_of_range_names_the_setting() -> None:
    with pytest.raises(InputError, match=r"skin\.reach_mm=0"):
        settings("rendering=subsurface", "rendering.skin.reach_mm=0")
