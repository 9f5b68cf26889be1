"""A camera's file may come from anybody: what is built from it, and what is refused in one line."""

from pathlib import Path
from typing import Any

import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

import lrsr.camera
from lrsr.camera.camera import Camera
from lrsr.camera.preset_file import _PARTS, read_preset_file
from lrsr.errors import InputError
from lrsr.paths import config_folder

PRESETS = sorted((config_folder() / "camera").glob("*.yaml"))
TOP = "_target_: lrsr.camera.Camera\n"


def written(folder: Path, content: str | bytes) -> Path:
    path = folder / "door.yaml"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@pytest.mark.parametrize("path", PRESETS, ids=lambda path: path.stem)
def test_every_shipped_preset_passes_unchanged(path: Path) -> None:
    assert read_preset_file(path) == OmegaConf.to_container(OmegaConf.load(path))


def test_parts_are_those_of_the_package_by_both_of_their_paths() -> None:
    paths = {f"lrsr.camera.{name}" for name in lrsr.camera.__all__}
    paths |= {f"{getattr(lrsr.camera, n).__module__}.{n}" for n in lrsr.camera.__all__}
    assert set(_PARTS) == paths


@pytest.mark.parametrize(
    "edited",
    [
        lambda text: b"\xef\xbb\xbf" + text.encode(),
        lambda text: text.replace("\n", "\r\n").encode(),
        lambda text: text.encode("utf-16"),
        lambda text: text.rstrip("\n").encode(),
        lambda text: f"---\n{text}...\n".encode(),
    ],
    ids=["byte-order mark", "CRLF", "UTF-16", "no last newline", "document marks"],
)
def test_what_other_editors_write_is_read(edited: Any, tmp_path: Path) -> None:
    preset = config_folder() / "camera" / "webcam.yaml"
    found = read_preset_file(written(tmp_path, edited(preset.read_text())))
    assert found == read_preset_file(preset)
    assert isinstance(instantiate(found), Camera)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", "it holds nothing; begin with a copy of a preset"),
        ("# to do\n", "it holds nothing"),
        ("{}\n", "it holds nothing"),
        ("- _target_: lrsr.camera.Camera\n", "it holds no `_target_: lrsr.camera.Camera`"),
        ("hello\n", "it holds no `_target_"),
        ("7\n", "Invalid loaded object type: int; begin with"),
        ("name: door\n", "it holds no `_target_"),
        ("_target_: lrsr.camera.Sensor\n", "it is a part of a camera only; begin"),
        (f"camera:\n  {TOP}", "it holds no `_target_"),
        ("a: [1\n", "no configuration"),
        (b"\xff\xfe\x00", "no configuration"),
        (b"name: \xe9\n", "no configuration"),
        (f"{TOP}name: a\nname: b\n", "no configuration: while constructing a mapping"),
        (f"{TOP}---\n{TOP}", "no configuration"),
        ("[" * 3000, "it goes more than 20 levels deep"),
        ("#" * 70_000, "70000 bytes are too many for a camera"),
    ],
)
def test_what_describes_no_camera_is_refused_with_the_remedy(
    content: str | bytes, says: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as caught:
        read_preset_file(written(tmp_path, content))
    assert str(caught.value).startswith(f"camera={tmp_path / 'door.yaml'}: ")
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "target",
    [
        "os.system",
        "lrsr.camera.sensor.torch.save",
        "lrsr.camera.camera.torch.load",
        "lrsr.camera.preset_file.Path.unlink",
        "lrsr.camera.codec.cv2.imwrite",
        "lrsr.camera.sensor.Sensor.load_state_dict",
        "lrsr.camera.camera.preset_file.yaml.load",
        "lrsr.camera.codec.jpeg",
        "lrsr.camera.camera.Sensor",
        "lrsr.camera..Camera",
        " lrsr.camera.Camera",
        "builtins.exec",
        "[lrsr.camera.Sensor]",
        "null",
    ],
)
def test_nothing_but_parts_of_a_camera_is_built(target: str, tmp_path: Path) -> None:
    for key in ("sensor", "optics", "name", "origin_px"):
        stolen = tmp_path / "stolen"
        trap = written(tmp_path, f"{TOP}{key}:\n  _target_: '{target}'\n  f: {stolen}\n")
        with pytest.raises(InputError, match=r"builds no part of lrsr\.camera; remove it"):
            read_preset_file(trap)
        assert list(tmp_path.iterdir()) == [trap]


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ("sensor:\n  _target_: lrsr.camera.Sensor\n  _args_: [1]\n", "sensor._args_=[1]: Sensor"),
        ("_partial_: true\n", "_partial_=True: Camera has no such setting"),
        ("_recursive_: false\n", "_recursive_=False: Camera has no such"),
        ("_convert_: object\n", "_convert_=object: Camera has no such"),
        ("defaults: [base]\n", "defaults=['base']: Camera has no such"),
        ("hydra: {run: {dir: /tmp}}\n", "hydra={'run': {'dir': '/tmp'}}: Camera has no such"),
        ("nmae: door\n", "nmae=door: Camera has no such setting; did you mean name?"),
        ("name: ${oc.env:HOME}\n", "name=${oc.env:HOME} is computed; write the value itself"),
        ("origin_px: [1, '${a}']\n", "origin_px[1]=${a} is computed"),
        ("name: ???\n", "name=??? is computed"),
        ("sensor: {_target_: lrsr.camera.Sensor, bits: 12, bitz: 1}\n", "did you mean bits?"),
        ("sensor: {_target_: lrsr.camera.Sensor, bits: many}\n", "sensor.bits=many: wanted 8 to"),
        ("sensor: {_target_: lrsr.camera.Sensor, gain: .nan}\n", "sensor.gain=nan: wanted a f"),
        ("sensor: {_target_: lrsr.camera.Sensor, gain: [1]}\n", "sensor.gain=[1]: wanted a f"),
        ("optics: {_target_: lrsr.camera.Optics, f_number: yes}\n", "optics.f_number True: give"),
        ("optics: {_target_: lrsr.camera.Optics, f_number: {a: 1}}\n", "optics.f_number: _target_"),
        ("optics: {_target_: lrsr.camera.Sensor}\n", "optics=Sensor("),
        ("optics: [1]\n", "optics=[1]: wanted Optics, or null"),
        ("mosaic: RGGB\n", "mosaic=RGGB: wanted Mosaic, or null"),
        ("name: [a, b]\n", "name=['a', 'b']: wanted a word"),
        ("compression: 7\n", "compression=7: wanted one of none"),
        ("compression: [none]\n", "compression=['none']: wanted one of none"),
        ("1: 2\n", "1=2: Camera has no such setting"),
        ("exposure_ev: 1e999\n", "exposure_ev=inf: wanted"),
        (f"exposure_ev: {'9' * 500}\n", "wanted -100..100"),
        ("colour: {_target_: lrsr.camera.SpectralColour, sensitivities: 7}\n", "sensitivities=7"),
        ("stored: {_target_: lrsr.camera.Jpeg, qualities: {a: 1}}\n", "stored.qualities"),
        (
            "optics: {_target_: lrsr.camera.Optics, distortion: 1}\n",
            "optics.distortion=1: wanted 2",
        ),
    ],
)
def test_a_setting_that_is_none_is_named_with_its_value(
    lines: str, says: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as caught:
        read_preset_file(written(tmp_path, TOP + lines))
    assert str(caught.value).startswith(f"camera={tmp_path / 'door.yaml'}: ")
    assert says in str(caught.value)


def test_a_bomb_of_aliases_is_refused_before_it_is_unfolded(tmp_path: Path) -> None:
    levels = "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]\n" for k in range(1, 30))
    with pytest.raises(InputError, match=r"\*a0 repeats something; write the value itself"):
        read_preset_file(written(tmp_path, f"{TOP}a0: &a0 [1]\n{levels}"))


def test_headers_that_hydra_would_obey_are_not_handed_on(tmp_path: Path) -> None:
    found = read_preset_file(written(tmp_path, f"# @package _global_\n{TOP}name: door\n"))
    assert found == {"_target_": "lrsr.camera.Camera", "name": "door"}


def test_a_file_that_is_not_there_or_a_folder_is_refused(tmp_path: Path) -> None:
    for path, what in ((tmp_path / "nowhere.yaml", "is missing"), (tmp_path, "is a folder")):
        with pytest.raises(InputError, match=f"{what}.*: give a preset's name or its"):
            read_preset_file(path)
