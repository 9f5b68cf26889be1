"""``lrsr render`` as a function: pictures, manifest, and a second call that goes on."""

import errno
import json
import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch
from fakes.maker import FakeMaker
from fakes.scenes import LENSES, LIGHTINGS, SKINS, recipe, scene
from fakes.twins import TwinMaker, traits

import lrsr.pictures.to_folder as module
from lrsr.camera import Camera
from lrsr.camera.exposure import KEY
from lrsr.camera.sensor import Sensor
from lrsr.camera.spectral import SpectralColour
from lrsr.errors import InputError
from lrsr.identities.face.expression import Expression
from lrsr.identities.head import Head
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.person import Traits
from lrsr.identities.population import Population
from lrsr.identities.roster import IdentityRange, Roster, write_roster
from lrsr.images import linear_to_srgb
from lrsr.pictures.burst import Burst
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.folder import read_manifest
from lrsr.pictures.image_files import read_image
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.render import load_radiances, take_pictures
from lrsr.pictures.sitting import Sitting
from lrsr.pictures.to_folder import RenderSettings, render_to_folder
from lrsr.presets import preset
from lrsr.rendering.pose import Pose
from lrsr.rendering.radiance import Radiance
from lrsr.rendering.scene import Film, Quality
from lrsr.rendering.standpoint import Standpoint


@pytest.fixture
def settings(tmp_path: Path) -> RenderSettings:
    """Return two people as the paper's first option, 8 px, by the reference camera."""
    sitting = Sitting(IdentityRange(count=2), scene(), Film(), Quality())
    return RenderSettings(tmp_path / "out", sitting, Camera())


def changed(
    settings: RenderSettings,
    *,
    people: dict[str, Any] | None = None,
    sitting: dict[str, Any] | None = None,
    **more: Any,
) -> RenderSettings:
    """Return the settings with other people, another sitting or other fields of their own."""
    before = settings.sitting
    who = replace(before.people, **(people or {}))
    return replace(settings, sitting=replace(before, people=who, **(sitting or {})), **more)


def render(settings: RenderSettings, maker: FakeMaker) -> Path:
    """Render with the cache beside the folder."""
    return render_to_folder(settings, cache_of(settings), progress=False, maker=maker)


def cache_of(settings: RenderSettings) -> RenderCache:
    return RenderCache(settings.out.parent / "cache")


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_every_person_and_film_is_a_picture_with_a_row(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    settings = changed(
        settings,
        people={"start": 5, "count": 3},
        sitting={"scene": scene("left")},
        scales=(1, 2, 4),
        compression="small",
    )
    assert render(settings, maker) == settings.out / "manifest.csv"
    rows = read_manifest(settings.out)
    assert len(rows) == 9
    assert {row.file for row in rows} | {"manifest.csv"} == set(contents(settings.out))
    assert {row.identity_id for row in rows} == {"test-00005", "test-00006", "test-00007"}
    assert {(row.kind, row.pose, row.lighting) for row in rows} == {("probe", "left", "frontal")}
    assert {(row.scale, row.compression) for row in rows} == {
        (1, "small"),
        (2, "none"),
        (4, "none"),
    }
    for row in rows:
        assert read_image(settings.out / row.file).shape == (3, 32 * row.scale, 32 * row.scale)
        assert row.landmarks_px == tuple(float(i * row.scale) for i in range(10))


def test_a_picture_is_the_probe_bit_for_bit(settings: RenderSettings, maker: FakeMaker) -> None:
    settings = replace(settings, compression="heavy", camera=Camera(exposure_ev=-1.0, name="dark"))
    render(settings, maker)
    recipes = settings.sitting.recipes()
    probes = take_pictures(recipes, cache_of(settings), Camera("heavy", -1.0), maker=maker)
    assert len(maker.renders) == 2
    for row, probe, one in zip(read_manifest(settings.out), probes, recipes, strict=True):
        assert torch.equal(read_image(settings.out / row.file), probe.image)
        assert (row.camera, row.compression) == ("dark", "heavy")
        assert (row.identity_id, row.seed, row.run_seed) == (one.person.id, one.seed, 0)


def test_a_row_says_what_stood_before_the_camera(settings: RenderSettings) -> None:
    asked = scene(Pose("mine", 5, -3, 1), "side", "single", "scface_far", "smile")
    quality = Quality(100, skin=SKINS["subsurface"])
    sitting = {"scene": asked, "quality": quality, "film": Film(9.5), "seed": 7}
    render(changed(settings, sitting=sitting), TwinMaker())
    row = read_manifest(settings.out)[1]
    assert (row.pose, row.yaw_deg, row.pitch_deg, row.roll_deg) == ("mine", 5.0, -3.0, 1.0)
    assert (row.lighting, row.lens, row.standpoint) == ("side", "single", "scface_far")
    assert (row.expression, row.skin, row.samples_per_pixel) == ("smile", "jensen_skin1", 100)
    assert (row.ipd_px, row.scale, row.run_seed) == (9.5, 1, 7)
    who = traits(recipe(1).person)
    assert (row.sex, row.age_years, row.skin_tone) == (who.sex, f"{who.age_years:g}", who.skin_tone)


def test_a_row_says_what_another_day_has_changed(settings: RenderSettings) -> None:
    class Dresser(FakeMaker):
        def render(self, head: Head, recipe: Recipe) -> Radiance:
            came = {"hair": "cut", "years": 4.2}
            traits = Traits("female", 40.0, {"asian": 1.0}, 30.0, "intermediate", changes=came)
            return replace(super().render(head, recipe), traits=traits)

    day = replace(settings.sitting, scene=scene(another_day="everything"))
    cache = RenderCache(settings.out / "cache")
    render_to_folder(replace(settings, sitting=day), cache, progress=False, maker=Dresser())
    (*_, row) = read_manifest(settings.out)
    assert (row.another_day, row.changes) == ("everything", "hair=cut years=4.2")
    assert "_everything_" in row.file
    told = json.loads(row.settings)["recipe"]["another_day"]
    assert told["glasses"] == 0.35


def test_what_is_unusual_is_named_in_the_file(settings: RenderSettings, maker: FakeMaker) -> None:
    render(settings, maker)
    asked = scene(lens="single", standpoint="scface_far", expression="smile")
    render(changed(settings, sitting={"scene": asked}), maker)
    files = [row.file for row in read_manifest(settings.out)]
    stems = [re.sub(r"_[0-9a-f]{8}_", "_", file).removesuffix("png") for file in files]
    assert stems[:3:2] == [
        "test-00000_probe_frontal_frontal_none_ipd8_x1.",
        "test-00000_probe_frontal_frontal_none_smile_single_scface_far_ipd8_x1.",
    ]


def test_everything_that_made_a_picture_is_told(settings: RenderSettings, maker: FakeMaker) -> None:
    camera = Camera(exposure_ev=0.5, name="mine")
    render(replace(settings, camera=camera, camera_settings={"lens": "glass"}), maker)
    first = read_manifest(settings.out)[0]
    told = json.loads(first.settings)
    assert told["recipe"] == json.loads(
        json.dumps(settings.sitting.recipes()[0].plain(maker.versions))
    )
    assert told["camera"] == {
        "name": "mine",
        "exposure_ev": 0.5,
        "compression": "none",
        "bands": 0,
        "adapted": False,
        "lens": "glass",
    }


DIFFERENT: dict[str, dict[str, Any]] = {
    "angles of a pose": {"sitting": {"scene": scene(Pose("frontal", yaw_deg=25))}},
    "more fill": {
        "sitting": {"scene": scene(lighting=replace(LIGHTINGS["frontal"], fill_share=0.9))}
    },
    "f-number": {"sitting": {"scene": scene(lens=replace(LENSES["thin"], name="pinhole"))}},
    "face units": {"sitting": {"scene": scene(expression=Expression("neutral", {"jawOpen": 0.1}))}},
    "height": {"sitting": {"scene": scene(standpoint=Standpoint("level", height_m=2.5))}},
    "run": {"sitting": {"seed": 7}},
    "kind": {"sitting": {"kind": "gallery"}},
    "size": {"sitting": {"film": Film(8.0000001)}},
    "bands": {"sitting": {"film": Film(bands=7)}},
    "rays": {"sitting": {"quality": Quality(513)}},
    "depth": {"sitting": {"quality": Quality(max_depth=6)}},
    "texture": {"sitting": {"quality": Quality(texture_size=64)}},
    "skin": {"sitting": {"quality": Quality(skin=replace(SKINS["subsurface"], name="reflective"))}},
    "exposure": {"camera": Camera(exposure_ev=0.1)},
    "sensor": {"camera": Camera(sensor=Sensor(200.0)), "camera_settings": {"full_well_e": 200}},
    "film of a camera": {"camera": Camera(bands=35)},
    "compression": {"compression": "small"},
}


@pytest.mark.parametrize("name", DIFFERENT)
def test_a_picture_that_differs_in_anything_is_another_file(
    settings: RenderSettings, maker: FakeMaker, name: str
) -> None:
    render(settings, maker)
    before = contents(settings.out)
    render(changed(settings, **DIFFERENT[name]), maker)
    rows = read_manifest(settings.out)
    assert len({row.file for row in rows}) == len(rows) == 4
    after = contents(settings.out)
    assert all(after[file] == before[file] for file in before if file != "manifest.csv")


def test_references_of_two_cameras_that_see_white_otherwise_are_two_files(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    for balance in ("scene", "daylight"):
        colour = SpectralColour("nikon_d5100", balance=balance)
        render(replace(settings, camera=Camera(colour=colour, name="nikon"), scales=(2,)), maker)
    rows = read_manifest(settings.out)
    assert len({row.file for row in rows}) == 4
    assert {row.camera for row in rows} == {"reference"}


def test_new_code_makes_new_files(settings: RenderSettings, maker: FakeMaker) -> None:
    render(settings, maker)
    maker.versions = {**maker.versions, "renderer": "2"}
    render(settings, maker)
    assert len(read_manifest(settings.out)) == 4


def test_the_sixteen_bit_file_holds_the_exposed_light(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    render(replace(settings, png16=True), maker)
    lights = load_radiances(settings.sitting.recipes(), cache_of(settings), maker=maker)
    for row, light in zip(read_manifest(settings.out), lights, strict=True):
        linear = read_image(settings.out / row.linear_file)
        assert torch.allclose(linear, (KEY * light.image / light.metered).clamp(0, 1), atol=1e-5)
        encoded = (linear_to_srgb(linear) * 255).round() / 255
        assert float((encoded - read_image(settings.out / row.file)).abs().max()) <= 1.001 / 255


def test_an_enrolled_picture_is_taken_without_flaws_or_compression(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    flawed = Camera(exposure_ev=-1.0, supersampling=4, sensor=Sensor(200.0), name="flawed")
    asked = {"kind": "gallery", "film": Film(64.0), "quality": Quality(64)}
    render(changed(settings, sitting=asked, camera=flawed, compression="heavy"), maker)
    for row in read_manifest(settings.out):
        assert (row.kind, row.camera, row.compression) == ("gallery", "reference", "none")
        assert (row.ipd_px, row.scale, row.samples_per_pixel) == (64.0, 1, 64)
        assert read_image(settings.out / row.file).shape == (3, 256, 256)
    assert {made.film for made in maker.renders} == {Film(64.0)}


def test_a_second_call_renders_nothing_and_changes_no_byte(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    render(settings, maker)
    before = contents(settings.out)
    render(settings, maker)
    assert contents(settings.out) == before
    assert len(maker.renders) == 2


def test_another_call_adds_its_rows(settings: RenderSettings, maker: FakeMaker) -> None:
    render(settings, maker)
    render(changed(settings, sitting={"kind": "gallery"}), maker)
    render(replace(settings, camera=Camera(name="second")), maker)
    assert [(row.kind, row.camera) for row in read_manifest(settings.out)] == [
        ("probe", "reference"),
        ("probe", "reference"),
        ("gallery", "reference"),
        ("gallery", "reference"),
        ("probe", "second"),
        ("probe", "second"),
    ]


def test_somebody_elses_rows_and_columns_stay(settings: RenderSettings, maker: FakeMaker) -> None:
    settings.out.mkdir()
    (settings.out / "anna.png").touch()
    (settings.out / "manifest.csv").write_text("note;file;identity_id\nmine;anna.png;anna\n")
    render(settings, maker)
    rows = read_manifest(settings.out)
    assert [row.identity_id for row in rows] == ["anna", "test-00000", "test-00001"]
    assert [row.further for row in rows] == [{"note": "mine"}, {"note": ""}, {"note": ""}]


def test_rows_of_pictures_that_were_removed_go(settings: RenderSettings, maker: FakeMaker) -> None:
    render(settings, maker)
    first, second = read_manifest(settings.out)
    (settings.out / first.file).unlink()
    render(changed(settings, sitting={"scene": scene("up")}), maker)
    files = [row.file for row in read_manifest(settings.out)]
    assert second.file in files
    assert first.file not in files
    render(settings, maker)
    assert len(read_manifest(settings.out)) == 4


def test_stopped_in_the_middle_it_goes_on(settings: RenderSettings) -> None:
    class Failing(FakeMaker):
        def render(self, head: Head, recipe: Recipe) -> Radiance:
            if len(self.renders) == 3:
                raise KeyboardInterrupt
            return super().render(head, recipe)

    settings = changed(settings, people={"count": 5})
    with pytest.raises(KeyboardInterrupt):
        render(settings, Failing())
    assert not (settings.out / "manifest.csv").exists()
    again = FakeMaker()
    render(settings, again)
    assert len(again.renders) == 2
    assert len(read_manifest(settings.out)) == 5


def test_what_a_killed_call_left_is_swept(settings: RenderSettings, maker: FakeMaker) -> None:
    settings.out.mkdir()
    (settings.out / ".test-00000.png.01234567.part").touch()
    render(settings, maker)
    assert not list(settings.out.glob("*.part"))


def test_a_pose_of_ones_own_is_a_safe_file_name(settings: RenderSettings, maker: FakeMaker) -> None:
    mine = scene(Pose("../over there", yaw_deg=5.0))
    render(changed(settings, sitting={"scene": mine}), maker)
    for row in read_manifest(settings.out):
        assert row.pose == "../over there"
        assert "/" not in row.file
        assert " " not in row.file


def test_pictures_differ_in_their_noise(settings: RenderSettings, maker: FakeMaker) -> None:
    render(replace(settings, scales=(1, 2)), maker)
    render(changed(settings, sitting={"seed": 1}), maker)
    assert len({row.seed for row in read_manifest(settings.out)}) == 6


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"scales": ()}, r"scales=\[\]: wanted at least one"),
        ({"scales": (5,)}, "scale=5: wanted one of"),
        ({"compression": "much"}, "compression.*much"),
    ],
    ids=["no films", "another film", "compression"],
)
def test_a_wrong_setting_is_one_line_before_any_work(
    settings: RenderSettings, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        replace(settings, **changes)
    assert not settings.out.exists()


def test_out_that_is_a_file_is_one_line(settings: RenderSettings, maker: FakeMaker) -> None:
    settings.out.touch()
    with pytest.raises(InputError, match=r"out=.*out is a file: give a folder"):
        render(settings, maker)
    assert maker.renders == []


def test_a_broken_manifest_is_not_written_over(settings: RenderSettings, maker: FakeMaker) -> None:
    settings.out.mkdir()
    (settings.out / "manifest.csv").write_text("mine\n1\n")
    with pytest.raises(InputError, match=r"manifest\.csv, line 1: no column file"):
        render(settings, maker)
    assert (settings.out / "manifest.csv").read_text() == "mine\n1\n"


def test_a_full_disk_is_one_line_and_leaves_no_manifest(
    settings: RenderSettings, maker: FakeMaker, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[Path] = []

    def full(path: Path, image: torch.Tensor, *, bits: int = 8) -> None:
        written.append(path)
        if len(written) == 2:
            raise InputError(f"cannot write {path}: {os.strerror(errno.ENOSPC)}")

    monkeypatch.setattr(module, "write_png", full)
    with pytest.raises(InputError, match="No space left on device"):
        render(settings, maker)
    assert not (settings.out / "manifest.csv").exists()


def test_who_is_on_the_roster_is_who_is_rendered(
    settings: RenderSettings, maker: FakeMaker, tmp_path: Path
) -> None:
    women = Population("female")
    roster = Roster("test", 0, 2, women, RECIPE_VERSION, "dlib", 11.2, {1: 3})
    path = write_roster(tmp_path / "roster.json", roster)
    render(changed(settings, people={"sex": "female", "roster": str(path)}), maker)
    names = [row.identity_id for row in read_manifest(settings.out)]
    assert names == ["test-00000-female", "test-00001-female-draw3"]


def test_only_the_probe_has_the_flaws_of_the_camera(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    flawed = Camera(exposure_ev=-1.0, supersampling=4, sensor=Sensor(200.0), name="flawed")
    settings = changed(settings, people={"count": 1}, camera=flawed, scales=(1, 2), png16=True)
    render(settings, maker)
    assert sorted(made.film.scale for made in maker.renders) == [2, 4]
    probe, reference = sorted(read_manifest(settings.out), key=lambda row: row.scale)
    assert (probe.camera, reference.camera) == ("flawed", "reference")
    assert re.fullmatch(
        r"test-00000_probe_frontal_frontal_none_flawed_[0-9a-f]{8}_ipd8_x1\.png", probe.file
    )
    assert re.fullmatch(
        r"test-00000_probe_frontal_frontal_none_[0-9a-f]{8}_ipd8_x2\.png", reference.file
    )
    assert read_image(settings.out / probe.file).shape == (3, 32, 32)
    assert read_image(settings.out / probe.linear_file).shape == (3, 32, 32)
    plain = replace(settings, out=settings.out / "plain", camera=Camera(exposure_ev=-1.0))
    render(plain, maker)
    ours, theirs = (read_image(s.out / reference.file) for s in (settings, plain))
    assert torch.equal(ours, theirs)
    gallery = changed(settings, sitting={"kind": "gallery"})
    assert gallery.shoot(1).camera.flawless


def test_a_camera_with_measured_filters_has_references_of_the_same_bands(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    real = Camera(supersampling=2, colour=SpectralColour("nikon_d5100"), name="nikon")
    settings = changed(settings, people={"count": 1}, camera=real, scales=(1, 2), png16=True)
    render(settings, maker)
    assert [(made.film.scale, made.film.bands) for made in maker.renders] == [(2, 35)] * 2
    rows = sorted(read_manifest(settings.out), key=lambda row: row.scale)
    assert [row.camera for row in rows] == ["nikon", "reference"]
    assert read_image(settings.out / rows[0].linear_file).shape == (3, 32, 32)
    assert read_image(settings.out / rows[1].linear_file).shape == (3, 64, 64)


def test_a_camera_with_a_lens_and_a_lens_before_it_are_one_too_many(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"lens=single camera=axis_p1435le: two lenses"):
        RenderSettings(
            out=tmp_path,
            sitting=Sitting(
                IdentityRange(count=1), scene(lens="single"), Film(), Quality(texture_size=64)
            ),
            camera=preset("camera", "axis_p1435le"),
        )


def test_every_frame_is_a_picture_with_a_row_and_the_first_is_that_of_one_frame(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    moving = changed(settings, sitting={"burst": Burst("test", 0.1, yaw_deg=2)}, frames=3)
    render(settings, maker)
    (first, _) = read_manifest(settings.out)
    render(moving, maker)
    rows = read_manifest(settings.out)
    assert first in rows
    assert sorted((row.identity_id, row.frame) for row in rows) == [
        (person, frame) for person in ("test-00000", "test-00001") for frame in range(3)
    ]
    assert len({row.seed for row in rows}) == len({row.file for row in rows}) == 6
    later = next(row for row in rows if row.frame == 2)
    film = json.loads(later.settings)["recipe"]["film"]
    assert later.file.endswith("_ipd8_x1_frame2.png")
    assert 0 < abs(film["shift_px"][0]) <= 0.8
    assert 0 < abs(later.yaw_deg or 0) <= 2


def test_no_frame_is_refused(settings: RenderSettings) -> None:
    with pytest.raises(InputError, match="frames=0: wanted at least 1"):
        replace(settings, frames=0)
