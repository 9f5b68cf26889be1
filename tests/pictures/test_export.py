"""What ``lrsr identities export=DIR`` leaves, by a maker whose heads are eggs."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from fakes.maker import FakeMaker
from fakes.scenes import scene
from oracles.heads import stand_in

from lrsr.errors import InputError
from lrsr.identities.head import Head
from lrsr.identities.roster import IdentityRange
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.export import export_to_folder
from lrsr.pictures.folder import read_folder
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.sitting import Sitting
from lrsr.pictures.to_folder import RenderSettings
from lrsr.presets import preset
from lrsr.rendering.scene import Film, Quality
from lrsr.rendering.survey import Survey

DEPTH_M = 1.2345


class Surveyor(FakeMaker):
    """Sees half a frame of skin at one distance, turned to the camera."""

    def __init__(self, dies_after: int = 99) -> None:
        super().__init__()
        self.surveys: list[str] = []
        self.dies_after = dies_after

    def head(self, recipe: Recipe) -> Head:
        super().head(recipe)
        return replace(stand_in(recipe.person.index), identity_id=recipe.person.id)

    def survey(self, head: Head, recipe: Recipe) -> Survey:
        if len(self.surveys) == self.dies_after:
            raise KeyboardInterrupt
        self.surveys.append(head.identity_id)
        side = 4 * round(recipe.film.ipd_px)
        parts = np.zeros((side, side), np.uint8)
        parts[:, side // 2 :] = 1
        depth = np.where(parts > 0, DEPTH_M, 0).astype(np.float32)
        normals = (parts[..., None] * np.array([0, 0, 1.0])).astype(np.float32)
        names = tuple(part.name for part in head.parts)
        return Survey(depth, normals, parts, names, np.eye(4), 500.0, (0.0, 0.0))


def settings(out: Path, **before: Any) -> RenderSettings:
    people = IdentityRange(split="test", start=0, count=2)
    sitting = Sitting(people, scene(**before), Film(8), Quality(16, texture_size=64))
    return RenderSettings(out, sitting, preset("camera", "reference"))


@pytest.fixture
def cache(tmp_path: Path) -> RenderCache:
    return RenderCache(tmp_path / "cache")


def export(out: Path, cache: RenderCache, maker: Surveyor, **before: Any) -> Path:
    return export_to_folder(settings(out, **before), cache, progress=False, maker=maker)


def test_each_person_has_meshes_picture_depth_normals_parts_and_landmarks(
    tmp_path: Path, cache: RenderCache
) -> None:
    export(tmp_path / "out", cache, Surveyor())
    folders = sorted(path for path in (tmp_path / "out").iterdir() if path.is_dir())
    assert [folder.name[:10] for folder in folders] == ["test-00000", "test-00001"]
    wanted = {"picture.png", "head.glb", "head.obj", "head.mtl", "skin.png", "depth_mm.png"}
    wanted |= {"normals.png", "parts.png", "geometry.npz", "landmarks.json"}
    assert wanted <= {path.name for path in folders[0].iterdir()}


def test_depth_is_in_whole_millimetres_and_in_exact_metres(
    tmp_path: Path, cache: RenderCache
) -> None:
    out = export(tmp_path / "out", cache, Surveyor()).parent
    folder = next(path for path in out.iterdir() if path.is_dir())
    depth = cv2.imread(str(folder / "depth_mm.png"), cv2.IMREAD_UNCHANGED)
    assert depth.dtype == np.uint16
    assert np.unique(depth).tolist() == [0, 1234]
    with np.load(folder / "geometry.npz") as arrays:
        assert arrays["depth_m"].max() == np.float32(DEPTH_M)
        parts = arrays["parts"]
    shown = cv2.imread(str(folder / "parts.png"), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(shown, parts)
    normals = cv2.imread(str(folder / "normals.png"))[..., ::-1]
    assert normals[0, -1].tolist() == [128, 128, 255]
    assert normals[0, 0].tolist() == [0, 0, 0]


def test_landmarks_are_those_of_head_and_picture(tmp_path: Path, cache: RenderCache) -> None:
    out = export(tmp_path / "out", cache, Surveyor()).parent
    told = json.loads(next(out.glob("test-00001*/landmarks.json")).read_text())
    head = stand_in(1)
    assert told["landmarks"]["nose"]["head_mm"] == [0.0, -40.0, 20.0]
    assert told["landmarks"]["nose"]["camera_mm"] == [0.0, -40.0, 20.0]
    assert told["landmarks"]["left_eye"]["image_px"] == [0.0, 1.0]  # as the fake renders
    assert told["ipd_mm"] == pytest.approx(head.ipd_mm, abs=1e-4)
    assert told["camera"] == {
        "head_to_camera": np.eye(4).tolist(),
        "focal_px": 500.0,
        "centre_px": [15.5, 15.5],
        "size_px": [32, 32],
    }
    assert told["parts"] == {"skin": 1, "left_eye_ball": 2, "right_eye_ball": 3}


def test_an_export_is_a_folder_of_pictures_like_others(tmp_path: Path, cache: RenderCache) -> None:
    out = export(tmp_path / "out", cache, Surveyor(), another_day="cap").parent
    rows = read_folder(out)
    assert [row.identity_id for row in rows] == ["test-00000", "test-00001"]
    assert {row.another_day for row in rows} == {"cap"}
    assert all((out / row.file).is_file() for row in rows)


def test_what_is_complete_is_not_made_again_and_another_pose_is_added(
    tmp_path: Path, cache: RenderCache
) -> None:
    export(tmp_path / "out", cache, Surveyor())
    again = Surveyor()
    export(tmp_path / "out", cache, again)
    assert not again.heads
    assert not again.surveys
    export(tmp_path / "out", cache, again, pose="left")
    assert len(again.surveys) == 2
    assert len(read_folder(tmp_path / "out")) == 4


def test_an_interrupted_export_goes_on(tmp_path: Path, cache: RenderCache) -> None:
    with pytest.raises(KeyboardInterrupt):
        export(tmp_path / "out", cache, Surveyor(dies_after=1))
    second = Surveyor()
    export(tmp_path / "out", cache, second)
    assert second.surveys == ["test-00001"]
    assert len(read_folder(tmp_path / "out")) == 2
    assert not list((tmp_path / "out").rglob("*.part"))


def test_a_lens_is_refused_before_any_work(tmp_path: Path, cache: RenderCache) -> None:
    maker = Surveyor()
    with pytest.raises(InputError, match="lens=single: depth and normals are those of"):
        export(tmp_path / "out", cache, maker, lens="single")
    assert not maker.heads
