import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import torch
from fakes.configurations import composed
from fakes.generators import write_generator
from numpy.typing import NDArray
from skimage.data import astronaut

from lrsr import cli
from lrsr.errors import InputError
from lrsr.experiments import generated_people, learned_directions
from lrsr.experiments.generated_people import GeneratedPeople
from lrsr.experiments.generation import Generating
from lrsr.experiments.learned_directions import Learning
from lrsr.identities.generated.boundaries import learn_boundaries, read_boundaries
from lrsr.identities.generated.generator import Generator
from lrsr.identities.photographs.quality import Filters, Quality
from lrsr.recognition.detection.faces import Detection

RNG = np.random.default_rng(8)
SIDE, SIZE = 16, 5
MATRIX = RNG.normal(0, 0.12, (3 * SIDE * SIDE, SIZE))
BASE = np.full((3, SIDE, SIDE), 0.5)
TURN = np.linalg.qr(RNG.standard_normal((SIZE, SIZE)))[0]
"""Maps z to w, so that attributes that follow z[0] and z[1] lie obliquely in w."""
FACE = Detection(
    np.array([2.0, 2, 14, 14], np.float32),
    0.9,
    np.array([[5, 6], [10, 6], [8, 9], [6, 12], [10, 12]], np.float32),
)
GOOD = Quality(60.0, 1.0, 2.0, -3.0, 1.0, 1.0, 1.5, 0.8, 40.0, 0.6, 0.1, (0.0, 0.0))


class FakeEncoder:
    """Embeds a picture as its pixels about grey."""

    def embed(self, srgb: torch.Tensor, *_: Any) -> NDArray[np.float32]:
        return (srgb - 0.5).flatten(1).numpy()

    def describe(self) -> dict[str, object]:
        return {"encoder": "fake"}


class Made:
    """A reconstruction of which the quality is all that is asked."""

    def __init__(self, photograph: Any, **_: Any) -> None:
        self.quality = replace(GOOD, yaw_deg=20 * float(photograph.srgb[..., 0].mean() - 0.5))


@pytest.fixture
def quickly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take every picture for a face that is well fitted; measure it by its pixels."""
    for module in (learned_directions, generated_people):
        monkeypatch.setattr(module, "portrait_faces", lambda *_: [FACE])
        monkeypatch.setattr(module, "AttributeMeter", lambda: _measure)
    monkeypatch.setattr(generated_people, "reconstruct", Made)


def _measure(photograph: Any) -> dict[str, float]:
    names = ("yaw_deg", "pitch_deg", "smile", "jaw_open", "light_across", "light_above")
    pixels = photograph.srgb - 0.5
    latent = np.linalg.lstsq(MATRIX, pixels.transpose(2, 0, 1).ravel(), rcond=None)[0]
    z = TURN.T @ (latent - 1)
    return dict(zip(names, (10 * z[0], z[1], 0.0, 0.0, float("nan"), 0.0), strict=True))


def generator_in(folder: Path) -> Path:
    return write_generator(folder / "synthesis.onnx", MATRIX, BASE, mapping=TURN, layers=3)


def asked(folder: Path, **settings: Any) -> Generating:
    usual: dict[str, Any] = {
        "generator": generator_in(folder),
        "count": 3,
        "seed": 4,
        "truncation": 1.0,
        "boundaries": None,
        "learning": Learning(samples=100, share=0.2),
        "attributes": {"yaw_deg": 0.0, "pitch_deg": None},
        "variations": {"yaw_deg": (-1.0, 1.0)},
        "encoder": "shipped",
        "smallest_angle_deg": 20.0,
        "device": "cpu",
    }
    return Generating(**usual | settings)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr("lrsr.experiments.generation.load_encoder", lambda *_, **__: FakeEncoder())
    return tmp_path


def rows_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "manifest.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.usefixtures("quickly")
def test_people_are_neutral_and_varied_as_asked(folder: Path) -> None:
    asked(folder).run(folder / "out", progress=False)
    boundaries = read_boundaries(folder / "out" / "boundaries.safetensors", SIZE)
    assert boundaries.normals[0] @ TURN[:, 0] > 0.97
    assert boundaries.normals[1] @ TURN[:, 1] > 0.97
    rows = rows_of(folder / "out")
    assert [(row["kind"], row["attribute"], row["increment"]) for row in rows[:3]] == [
        ("gallery", "", "0"),
        ("probe", "yaw_deg", "-1"),
        ("probe", "yaw_deg", "1"),
    ]
    assert len({row["identity_id"] for row in rows}) == 3
    record = json.loads((folder / "out" / "generated.json").read_text())
    assert all(abs(one["attributes"]["yaw_deg"]) < 3 for one in record["people"])  # drawn: 10
    assert record["people"][0]["attributes"]["light_across"] is None
    yaws = []
    for row in rows[:3]:
        pixels = cv2.imread(str(folder / "out" / row["file"]))[..., ::-1]
        photograph = type("P", (), {"srgb": pixels.astype(np.float32) / 255})
        yaws.append(_measure(photograph)["yaw_deg"])
    assert np.diff([yaws[1], yaws[0], yaws[2]]) == pytest.approx([10, 10], abs=2.5)
    sheet = cv2.imread(str(folder / "out" / "sheet.png"))
    assert sheet.shape[0] > 3 * 128


@pytest.mark.usefixtures("quickly")
def test_same_seed_same_bytes_however_it_was_interrupted(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked(folder).run(folder / "whole", progress=False)
    looks = GeneratedPeople._look

    def killed(self: GeneratedPeople, number: int) -> Any:
        if number == 1:
            raise KeyboardInterrupt
        return looks(self, number)

    with monkeypatch.context() as patch:
        patch.setattr(GeneratedPeople, "_look", killed)
        with pytest.raises(KeyboardInterrupt):
            asked(folder).run(folder / "parts", progress=False)
    first = next((folder / "parts" / "neutral").iterdir())
    first.unlink()
    asked(folder, count=2).run(folder / "parts", progress=False)
    asked(folder).run(folder / "parts", progress=False)
    files = [file.relative_to(folder / "whole") for file in (folder / "whole").rglob("*.*")]
    assert len(files) > 9
    for file in files:
        assert (folder / "parts" / file).read_bytes() == (folder / "whole" / file).read_bytes()


@pytest.mark.usefixtures("quickly")
def test_a_folder_of_other_settings_is_refused(folder: Path) -> None:
    asked(folder).run(folder / "out", progress=False)
    with pytest.raises(InputError, match="holds what another seed made"):
        asked(folder, seed=5).run(folder / "out", progress=False)


@pytest.mark.usefixtures("quickly")
def test_whoever_is_alike_or_filtered_is_counted(folder: Path) -> None:
    narrow = asked(folder, filters=Filters(most_yaw_deg=0.3), smallest_angle_deg=75.0)
    with pytest.raises(InputError, match=r"count=50: \d+ people are there, the last 8 drawn were"):
        replace(narrow, count=50, most_refused=8).run(folder / "out", progress=False)
    record = json.loads((folder / "out" / "generated.json").read_text())
    assert set(record["refused"]) == {"alike", "frontal"}
    assert len(record["people"]) + sum(record["refused"].values()) == record["drawn"]
    assert all(one["angle_deg"] >= 75 for one in record["people"][1:])


@pytest.mark.usefixtures("quickly")
def test_scores_of_others_and_kept_samples(folder: Path) -> None:
    generator = Generator(generator_in(folder))
    z = [np.random.default_rng((4, 0, k)).standard_normal(SIZE)[2] for k in range(150)]
    text = "".join(f"{k:05d}.png,{'' if k == 3 else value}\n" for k, value in enumerate(z))
    (folder / "scores.csv").write_text(f"file,age\n{text}")
    learning = Learning(150, 0.2, str(folder / "scores.csv"), keep=True)
    drawn = {"seed": 4, "truncation": 1.0}
    found = learning.learn(generator, {"age": None}, drawn, folder / "out", progress=False)
    assert found.normals[0] @ TURN[:, 2] > 0.97
    assert found.record["attributes"]["age"]["faces"] == 149
    assert len(list((folder / "out" / "samples").glob("*.png"))) == 150


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("file,age\n00150.png,3\n", "file 00150.png: wanted 00000.png to 00149.png"),
        ("file,age\n00000.png,old\n", "age='old' of 00000.png is no number"),
        ("name,age\n00000.png,3\n", "no column file among name, age"),
        ("file,years\n00000.png,3\n", "attributes=age: wanted one of yaw_deg"),
        (None, "cannot read"),
    ],
)
def test_scores_that_cannot_be_used_are_refused(folder: Path, text: str | None, says: str) -> None:
    if text is not None:
        (folder / "scores.csv").write_text(text)
    learning = Learning(150, 0.2, str(folder / "scores.csv"))
    drawn = {"seed": 4, "truncation": 1.0}
    with pytest.raises(InputError, match=says):
        learning.learn(Generator(generator_in(folder)), {"age": None}, drawn, folder / "out")


@pytest.mark.usefixtures("quickly")
def test_boundaries_of_an_earlier_run_serve_again(folder: Path) -> None:
    asked(folder, count=0).run(folder / "first", progress=False)
    assert not (folder / "first" / "neutral").exists()
    file = folder / "first" / "boundaries.safetensors"
    asked(folder, boundaries=file, count=1).run(folder / "second", progress=False)
    assert len(rows_of(folder / "second")) == 3
    assert not (folder / "second" / "samples").exists()
    with pytest.raises(InputError, match=r"variations.age: wanted one of yaw_deg, pitch_deg"):
        asked(folder, boundaries=file, variations={"age": (1.0,)}).run(folder / "third")


def test_a_real_face_is_found_fitted_and_compared(folder: Path) -> None:
    """A generator of one face, brighter or darker: everybody is alike."""
    face = astronaut()[:280, 60:400].astype(np.float32).transpose(2, 0, 1) / 255
    brightness = 0.02 * face.reshape(-1, 1)
    model = write_generator(folder / "face.onnx", brightness, face)
    generator = Generator(model)
    scores = np.linspace(-1, 1, 60)[:, None].astype(np.float32)
    boundaries = learn_boundaries(scores, {"b": scores[:, 0]}, {"b": 0.0}, 0.3, {})
    people = GeneratedPeople(
        folder, generator, boundaries, FakeEncoder(), 1, 1.0, {}, 5.0, Filters(least_seen=0.2)
    )  # fmt: skip
    people.find(2, 1, progress=False)
    taken, refused = people.looked
    assert taken["quality"]["ipd_px"] == pytest.approx(42.6, abs=3)
    assert taken["attributes"]["smile"] > 0.3
    assert (refused["filter"], refused["nearest"]) == ("alike", taken["identity_id"])
    assert refused["why"].endswith(f"from {taken['identity_id']}; smallest_angle_deg is 5")


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("count=-1", "count=-1: wanted at least 0"),
        ("truncation=2", "truncation=2.0: wanted 0 to 1"),
        ("smallest_angle_deg=90", "wanted 0 to 90 degrees"),
        ("most_refused=0", "most_refused=0: wanted at least 1"),
        ("device=tpu", "device=tpu: wanted one of auto, cpu, cuda"),
        ("encoder=facenet", "encoder=facenet: wanted one of"),
        ("learning.samples=0", "learning.samples=0: wanted at least 1"),
        ("learning.share=0.6", "learning.share=0.6: wanted above 0"),
        ("+attributes={a/b: 1}", "attributes=a/b: wanted letters, digits and _"),
        ("attributes.yaw_deg=left", "attributes.yaw_deg=left: wanted a number"),
        ("+variations.yaw_deg=2", "variations.yaw_deg=2: wanted a list"),
        ("filters.most_yaw_deg=-1", "filters.most_yaw_deg=-1.0: wanted 0 or more"),
    ],
)
def test_a_wrong_setting_is_named(setting: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        Generating.from_config(composed("generate", "generator=g.onnx", "out=x", setting))


def test_the_configuration_is_read() -> None:
    words = ["generator=g.onnx", "out=x", "+variations={yaw_deg: [-1, 2]}", "encoder=shipped"]
    found = Generating.from_config(composed("generate", *words))
    assert found.variations == {"yaw_deg": (-1.0, 2.0)}
    assert found.smallest_angle_deg == 20.0
    assert None not in vars(found.filters).values()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["boundaries=b.safetensors", "learning.samples=7"], "learning.samples: boundaries=FILE"),
        (["out=null"], "out=null: give the folder for the people"),
        ([], "g.onnx is missing: a model needs NAME.onnx and NAME.toml"),
    ],
    ids=["unread", "no folder", "no generator"],
)
def test_the_command_refuses_in_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    says: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["generate", "generator=g.onnx", "out=x", *words]) == 2
    assert says in capsys.readouterr().err
