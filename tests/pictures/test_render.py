"""``lrsr render`` as a function: pictures, manifest, and a second call that goes on."""

import errno
import os
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from fakes.maker import FakeMaker

import lrsr.data.render as render_module
from lrsr.camera import Camera
from lrsr.camera.exposure import KEY
from lrsr.camera.sensor import Sensor
from lrsr.camera.spectral import SpectralColour
from lrsr.data.cache import RenderCache
from lrsr.data.manifest import read_manifest
from lrsr.data.png import read_png
from lrsr.data.probes import load_probes, load_radiances
from lrsr.data.render import RenderSettings, render_to_folder
from lrsr.errors import InputError
from lrsr.identities.head import Head
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.population import Population
from lrsr.identities.roster import Cast, Roster
from lrsr.images import linear_to_srgb
from lrsr.rendering.radiance import Radiance
from lrsr.rendering.scene import Pose


@pytest.fixture
def settings(tmp_path: Path) -> RenderSettings:
    return RenderSettings(out=tmp_path / "out", count=2, cache=tmp_path / "cache")


def render(settings: RenderSettings, maker: FakeMaker) -> Path:
    return render_to_folder(settings, progress=False, maker=maker)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_every_person_and_film_is_a_picture_with_a_row(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    settings = replace(
        settings, start=5, count=3, scales=(1, 2, 4), pose="left", compression="small"
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
        assert read_png(settings.out / row.file).shape == (3, 32 * row.scale, 32 * row.scale)
        assert row.landmarks_px == tuple(float(i * row.scale) for i in range(10))


def test_a_picture_is_the_probe_bit_for_bit(settings: RenderSettings, maker: FakeMaker) -> None:
    settings = replace(settings, compression="heavy", camera=Camera(exposure_ev=-1.0, name="dark"))
    render(settings, maker)
    assert settings.cache is not None
    probes = load_probes(
        settings.recipes(1), RenderCache(settings.cache), Camera("heavy", -1.0), maker=maker
    )
    for row, probe in zip(read_manifest(settings.out), probes, strict=True):
        assert torch.equal(read_png(settings.out / row.file), probe.image)
        assert (row.camera, row.compression) == ("dark", "heavy")


def test_an_expression_is_named_in_the_manifest_and_in_the_file(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    for expression in ("neutral", "smile"):
        render(replace(settings, expression=expression), maker)
    rows = read_manifest(settings.out)
    assert [row.expression for row in rows] == ["neutral", "neutral", "smile", "smile"]
    assert ["_smile_" in row.file for row in rows] == [False, False, True, True]


def test_lens_and_standpoint_are_named_in_the_manifest_and_in_the_file(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    render(settings, maker)
    render(replace(settings, lens="single", standpoint="scface_far"), maker)
    rows = read_manifest(settings.out)
    assert [(row.lens, row.standpoint) for row in rows[::2]] == [
        ("pinhole", "level"),
        ("single", "scface_far"),
    ]
    assert ["_single_scface_far_" in row.file for row in rows] == [False, False, True, True]
    assert [recipe.lens for recipe in maker.renders] == ["pinhole"] * 2 + ["single"] * 2


def test_an_enrolled_picture_is_a_level_pinholes(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    asked = replace(settings, kind="gallery", lens="single", standpoint="scface_far")
    render(asked, maker)
    assert {(row.lens, row.standpoint) for row in read_manifest(settings.out)} == {
        ("pinhole", "level")
    }


def test_a_gallery_is_neutral(settings: RenderSettings, maker: FakeMaker) -> None:
    render(replace(settings, kind="gallery", expression="smile"), maker)
    assert {row.expression for row in read_manifest(settings.out)} == {"neutral"}


def test_the_sixteen_bit_file_holds_the_exposed_light(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    render(replace(settings, png16=True), maker)
    assert settings.cache is not None
    lights = load_radiances(settings.recipes(1), RenderCache(settings.cache), maker=maker)
    for row, light in zip(read_manifest(settings.out), lights, strict=True):
        linear = read_png(settings.out / row.linear_file)
        assert torch.allclose(linear, (KEY * light.image / light.metered).clamp(0, 1), atol=1e-5)
        encoded = (linear_to_srgb(linear) * 255).round() / 255
        assert float((encoded - read_png(settings.out / row.file)).abs().max()) <= 1.001 / 255


def test_a_gallery_is_frontal_large_and_not_compressed_whatever_is_asked(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    asked = replace(
        settings, kind="gallery", pose="up", lighting="side", compression="heavy", ipd_px=9.0
    )
    render(asked, maker)
    for row in read_manifest(settings.out):
        assert (row.kind, row.pose, row.lighting) == ("gallery", "frontal", "frontal")
        assert (row.compression, row.ipd_px, row.scale) == ("none", 64.0, 1)
        assert read_png(settings.out / row.file).shape == (3, 256, 256)
    assert {recipe.samples_per_pixel for recipe in maker.renders} == {64}


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
    render(replace(settings, kind="gallery"), maker)
    render(replace(settings, camera=Camera(name="second")), maker)
    rows = read_manifest(settings.out)
    assert [(row.kind, row.camera) for row in rows] == [
        ("probe", "second"),
        ("probe", "second"),
        ("gallery", "reference"),
        ("gallery", "reference"),
    ]


def test_rows_of_pictures_that_were_removed_go(settings: RenderSettings, maker: FakeMaker) -> None:
    render(settings, maker)
    first, second = read_manifest(settings.out)
    (settings.out / first.file).unlink()
    render(replace(settings, pose="up"), maker)
    files = [row.file for row in read_manifest(settings.out)]
    assert second.file in files
    assert first.file not in files
    render(settings, maker)
    assert len(read_manifest(settings.out)) == 4


def test_stopped_in_the_middle_it_goes_on(settings: RenderSettings) -> None:
    class Failing(FakeMaker):
        def render(self, head: Head, recipe: object) -> Radiance:
            if len(self.renders) == 3:
                raise KeyboardInterrupt
            return super().render(head, recipe)  # type: ignore[arg-type]  # a recipe it is

    settings = replace(settings, count=5)
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
    render(replace(settings, pose=Pose("../over there", yaw_deg=5.0)), maker)
    for row in read_manifest(settings.out):
        assert row.pose == "../over there"
        assert "/" not in row.file
        assert " " not in row.file


def test_pictures_differ_in_their_noise() -> None:
    settings = RenderSettings(out=Path("x"), count=4)
    recipes = [recipe for scale in (1, 2) for recipe in settings.recipes(scale)]
    assert len({recipe.seed for recipe in recipes}) == 8
    assert recipes[0].seed != replace(settings, seed=1).recipes(1)[0].seed


def test_the_users_cache_is_the_default(
    settings: RenderSettings,
    maker: FakeMaker,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("LRSR_CACHE", str(tmp_path / "mine"))
    render(replace(settings, cache=None), maker)
    assert len(list((tmp_path / "mine").rglob("*.safetensors"))) == 2


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"count": 0}, "identities.count=0: wanted a number >= 1"),
        ({"scales": ()}, r"scales=\[\]: wanted at least one"),
        ({"scales": (3,)}, "scale=3: wanted one of"),
        ({"compression": "much"}, "compression 'much': choose one of"),
        ({"pose": "sideways"}, "pose 'sideways' does not exist"),
        ({"expression": "laugh"}, "expression 'laugh' does not exist"),
        ({"lighting": "noon"}, "lighting 'noon' does not exist"),
        ({"split": "all"}, "split=all: wanted one of"),
        ({"ipd_px": -1.0}, "ipd_px=-1.0: wanted"),
    ],
    ids=lambda value: "".join(value) if isinstance(value, dict) else "",
)
def test_a_wrong_setting_is_one_line_before_any_work(
    settings: RenderSettings, maker: FakeMaker, changes: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        render(replace(settings, **changes), maker)  # type: ignore[arg-type]  # wrong on purpose
    assert maker.renders == []
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

    monkeypatch.setattr(render_module, "write_png", full)
    with pytest.raises(InputError, match="No space left on device"):
        render(settings, maker)
    assert not (settings.out / "manifest.csv").exists()


def test_who_is_cast_is_who_is_rendered(settings: RenderSettings, maker: FakeMaker) -> None:
    women = Population("female")
    cast = Cast(women, Roster("test", 0, 2, women, RECIPE_VERSION, "dlib", 11.2, {1: 3}))
    render(replace(settings, cast=cast), maker)
    names = [row.identity_id for row in read_manifest(settings.out)]
    assert names == ["test-00000-female", "test-00001-female-draw3"]
    with pytest.raises(InputError, match="covers test 0 to 1"):
        replace(settings, cast=cast, count=3)


def test_only_the_probe_has_the_flaws_of_the_camera(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    flawed = Camera(exposure_ev=-1.0, supersampling=4, sensor=Sensor(200.0), name="flawed")
    settings = replace(settings, count=1, camera=flawed, scales=(1, 2), png16=True)
    render(settings, maker)
    assert sorted(made.scale for made in maker.renders) == [2, 4]
    probe, reference = sorted(read_manifest(settings.out), key=lambda row: row.scale)
    assert (probe.camera, reference.camera) == ("flawed", "reference")
    assert probe.file == "test-00000_probe_frontal_frontal_none_flawed_ipd8_x1.png"
    assert reference.file == "test-00000_probe_frontal_frontal_none_ipd8_x2.png"
    assert read_png(settings.out / probe.file).shape == (3, 32, 32)
    assert read_png(settings.out / probe.linear_file).shape == (3, 32, 32)
    plain = replace(settings, out=settings.out / "plain", camera=Camera(exposure_ev=-1.0))
    render(plain, maker)
    ours, theirs = (read_png(s.out / reference.file) for s in (settings, plain))
    assert torch.equal(ours, theirs)
    gallery = replace(settings, kind="gallery", scales=(1,))
    assert gallery.camera_of(1).flawless


def test_a_camera_with_measured_filters_has_references_of_the_same_bands(
    settings: RenderSettings, maker: FakeMaker
) -> None:
    real = Camera(supersampling=2, colour=SpectralColour("nikon_d5100"), name="nikon")
    settings = replace(settings, count=1, camera=real, scales=(1, 2), png16=True)
    render(settings, maker)
    assert [(made.scale, made.bands) for made in maker.renders] == [(2, 35)] * 2
    rows = sorted(read_manifest(settings.out), key=lambda row: row.scale)
    assert [row.camera for row in rows] == ["nikon", "reference"]
    assert read_png(settings.out / rows[0].linear_file).shape == (3, 32, 32)
    assert read_png(settings.out / rows[1].linear_file).shape == (3, 64, 64)
