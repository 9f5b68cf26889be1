"""A folder of pictures in place of rendered people: what comes out is the same."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skimage.data
import torch
from fakes.painted import PaintedMaker

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.experiments.conditions import Condition
from lrsr.experiments.likeness import Truth
from lrsr.experiments.seen import Seen
from lrsr.experiments.verification import Verification
from lrsr.identities.head import Head
from lrsr.identities.roster import IdentityRange
from lrsr.pictures import source
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.folder import Entry, read_folder, read_manifest, write_manifest
from lrsr.pictures.image_files import read_image, write_png
from lrsr.pictures.picture import Picture
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.sitting import Sitting
from lrsr.pictures.to_folder import RenderSettings, render_to_folder
from lrsr.presets import preset
from lrsr.recognition import Engine
from lrsr.recognition.settings import RecognitionSettings
from lrsr.rendering.radiance import Radiance
from lrsr.rendering.scene import Film, Quality, Scene
from lrsr.sr import Bicubic

PEOPLE, QUALITY = IdentityRange(count=10), Quality(samples_per_pixel=4, texture_size=64)
FRONTAL = Scene(preset("lighting", "frontal"))
TURNED = Scene(preset("lighting", "below"), preset("pose", "left"))
DESIGN = Verification(
    name="folders",
    question="Are painted people told apart?",
    conditions=(Condition(1, TURNED, "small", 8.0),),
    upscalers={name: preset("sr", name) for name in ("base", "bicubic2", "srcnn4")},
    people=PEOPLE,
    quality=QUALITY,
    seed=5,
    gallery=Sitting(PEOPLE, FRONTAL, Film(32.0), QUALITY, "gallery", 5),
    camera=Camera(),
)
PHOTOGRAPHS = Condition(1, None, "small", 8.0, "left", "below")
PROBES = Sitting(PEOPLE, TURNED, Film(8.0), QUALITY.at(8.0), "probe", 5)


class FaintMaker(PaintedMaker):
    """Paints people who are hard to tell apart; notes whom it was asked for."""

    def __init__(self) -> None:
        self.rendered: list[Recipe] = []

    def render(self, head: Head, recipe: Recipe) -> Radiance:
        self.rendered.append(recipe)
        light = super().render(head, recipe)
        generator = torch.Generator().manual_seed(recipe.seed)
        noise = torch.rand(3, 4, 4, generator=generator)
        tones = torch.nn.functional.interpolate(noise[None], size=light.image.shape[-2:])[0]
        return replace(light, image=0.15 * light.image + 0.3 * tones)


@pytest.fixture
def maker() -> FaintMaker:
    return FaintMaker()


def render(folder: Path, maker: FaintMaker) -> tuple[Path, Path]:
    """Write probes with their references, and the gallery, as ``lrsr render`` does."""
    probes, gallery = folder / "probes", folder / "gallery"
    for settings in (
        RenderSettings(probes, PROBES, Camera(), compression="small", scales=(1, 2, 4)),
        RenderSettings(gallery, DESIGN.gallery, Camera(), compression="small"),
    ):
        render_to_folder(settings, RenderCache(folder / "cache"), progress=False, maker=maker)
    return probes, gallery


def run(folder: Path, design: Verification, maker: FaintMaker) -> dict[str, Any]:
    cache = RenderCache(folder / "cache")
    place = design.run(folder / "run", cache, maker=maker, progress=False)
    results: dict[str, Any] = json.loads((place / "results.json").read_text())
    return results


def test_pictures_of_a_folder_give_the_rows_of_the_people_they_show(
    tmp_path: Path, tone_model: Path, maker: FaintMaker
) -> None:
    asked = replace(DESIGN, recognition=RecognitionSettings(tone_model))
    probes, gallery = render(tmp_path, maker)
    rendered = run(tmp_path, asked, maker)
    read = run(
        tmp_path / "read",
        replace(asked, conditions=(PHOTOGRAPHS,), probes_folder=probes, gallery_folder=gallery),
        FaintMaker(),
    )
    assert not [*(tmp_path / "read" / "cache").rglob("*.safetensors")]
    assert 0.6 < rendered["rows"][0]["auc"] < 0.99  # hard enough to be a test
    named = {"setting": "photographs"}
    unknown = {"camera": "", "skin": ""}
    assert read["rows"] == [row | named | unknown for row in rendered["rows"]]
    assert read["comparisons"] == [test | named for test in rendered["comparisons"]]


def test_render_and_eval_share_the_cache(
    tmp_path: Path, tone_model: Path, maker: FaintMaker
) -> None:
    render(tmp_path, maker)
    assert len(maker.rendered) == 10 * (3 + 1)
    run(tmp_path, replace(DESIGN, recognition=RecognitionSettings(tone_model)), maker)
    assert len(maker.rendered) == 10 * (3 + 1)


def test_a_folder_may_stand_in_for_the_gallery_alone(
    tmp_path: Path, tone_model: Path, maker: FaintMaker
) -> None:
    _, gallery = render(tmp_path, maker)
    asked = replace(DESIGN, recognition=RecognitionSettings(tone_model))
    whole = run(tmp_path, asked, maker)
    half = run(tmp_path, replace(asked, gallery_folder=gallery), maker)
    assert [row["auc"] for row in half["rows"]] == [row["auc"] for row in whole["rows"]]
    assert half["config"]["gallery_folder"] == str(gallery)


def photographs(tmp_path: Path, maker: FaintMaker, change: Any) -> Verification:
    """Return an experiment on the written folders, some probes of which were changed."""
    probes, gallery = render(tmp_path, maker)
    rows = [row for row in read_manifest(probes) if row.scale == 1]
    write_manifest(probes, [change(probes, k, row) for k, row in enumerate(rows)])
    upscalers = {"base": DESIGN.upscalers["base"], "bicubic2": DESIGN.upscalers["bicubic2"]}
    folders = {"probes_folder": probes, "gallery_folder": gallery}
    return replace(DESIGN, conditions=(PHOTOGRAPHS,), upscalers=upscalers, **folders)


def test_a_probe_without_landmarks_is_a_failure_to_acquire(
    tmp_path: Path, tone_model: Path, maker: FaintMaker
) -> None:
    def forget(_: Path, number: int, row: Entry) -> Entry:
        return replace(row, landmarks_px=None) if number < 4 else row

    design = photographs(tmp_path, maker, forget)
    for row in run(tmp_path, replace(design, recognition=RecognitionSettings(tone_model)), maker)[
        "rows"
    ]:
        assert (row["fta"], row["n_genuine"], row["n_impostor"]) == (0.4, 6, 6 * 9)
        assert row["psnr_y_db"] is None  # the folder has no references any more


def test_probes_of_several_sizes_are_compared_but_not_shown(
    tmp_path: Path, tone_model: Path, maker: FaintMaker
) -> None:
    def crop(folder: Path, number: int, row: Entry) -> Entry:
        """Take away a margin on the right, which moves no landmark."""
        if number % 2:
            write_png(folder / row.file, read_image(folder / row.file)[..., :-1])
        return row

    design = photographs(tmp_path, maker, crop)
    rows = run(tmp_path, replace(design, recognition=RecognitionSettings(tone_model)), maker)[
        "rows"
    ]
    assert [(row["fta"], row["n_genuine"]) for row in rows] == [(0.0, 10)] * 2
    assert not (tmp_path / "run" / "faces_1.png").exists()


def test_manifests_are_read_once(
    tmp_path: Path, tone_model: Path, maker: FaintMaker, monkeypatch: pytest.MonkeyPatch
) -> None:
    design = photographs(tmp_path, maker, lambda _, __, row: row)
    read: list[Path] = []
    monkeypatch.setattr(source, "read_folder", lambda root: read.append(root) or read_folder(root))
    run(tmp_path, replace(design, recognition=RecognitionSettings(tone_model)), maker)
    assert sorted(read) == sorted([design.probes_folder, design.gallery_folder])


def test_pictures_of_turning_sizes_go_by_size_and_come_in_order(
    tmp_path: Path, tone_model: Path
) -> None:
    class Counting(Engine):
        def embed(self, srgb: Any, landmarks_px: Any) -> Any:
            batches.append(len(srgb))
            return super().embed(srgb, landmarks_px)

    batches: list[int] = []
    generator = torch.Generator().manual_seed(0)
    points = torch.rand(6, 5, 2, generator=generator) * 8
    images = [torch.rand(3, 12, 12 + k % 2, generator=generator) for k in range(6)]
    pictures = [Picture(image, "p", one, "") for image, one in zip(images, points, strict=True)]
    engine = Counting(tone_model)
    true = [replace(picture, image=picture.image.flip(-1)) for picture in pictures]
    seen = Seen(["shared"])
    seen.look(engine, pictures, Bicubic(1), Truth(true, engine))
    assert batches == [3, 3, 3, 3]  # the pictures, and the references
    for k, (one, other) in enumerate(zip(pictures, true, strict=True)):
        alone = Seen(["shared"])
        alone.look(engine, [one], Bicubic(1), Truth([other], engine))
        np.testing.assert_allclose(seen.joined("shared")[k], alone.joined("shared")[0], atol=1e-6)
        for name, (value,) in alone.likeness.items():
            assert seen.likeness[name][k] == pytest.approx(value, nan_ok=True)


def two_people(folder: Path) -> Path:
    """Write photographs of two people without landmarks: a rendered one and an astronaut."""
    data = Path(__file__).parents[1] / "data"
    astronaut = torch.from_numpy(skimage.data.astronaut()).permute(2, 0, 1)[:, 20:212, 130:322]
    for name, face in (
        ("one", read_image(data / "rendered_face.png")),
        ("other", astronaut.float() / 255),
    ):
        for number in range(2):
            write_png(folder / name / f"{number}.png", (face * (0.9 + 0.1 * number)).contiguous())
    return folder


def test_faces_on_photographs_without_landmarks_are_found(tmp_path: Path) -> None:
    folder = two_people(tmp_path / "people")
    photographs = {"probes_folder": folder, "gallery_folder": folder}
    design = replace(DESIGN, conditions=(PHOTOGRAPHS,), **photographs)
    upscalers = {"base": DESIGN.upscalers["base"]}
    both = RecognitionSettings(landmarks=("shared", "own"))
    (row,) = run(tmp_path, replace(design, upscalers=upscalers, recognition=both), FaintMaker())[
        "rows"
    ]
    assert (row["landmarks"], row["fta"], row["wrong_place"]) == ("own", 0.0, None)
    assert (row["n_genuine"], row["n_impostor"]) == (8, 8)
    assert row["auc"] == 1.0


def test_true_landmarks_that_nobody_knows_are_refused(tmp_path: Path) -> None:
    folder = two_people(tmp_path / "people")
    design = replace(DESIGN, conditions=(PHOTOGRAPHS,), probes_folder=folder)
    with pytest.raises(InputError, match=r"no picture in .*people has.*recognition\.landmarks=own"):
        run(tmp_path, design, FaintMaker())
    assert not (tmp_path / "cache").exists()
