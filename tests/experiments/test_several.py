"""Methods of several frames: what they make of a burst, and how they are read and compared."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.painted import PaintedMaker
from hydra import compose, initialize_config_dir

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.experiments.conditions import Condition
from lrsr.experiments.design import Design
from lrsr.experiments.several import Fused, Pooled, Several, read_several, see, surest
from lrsr.experiments.trial import Trial
from lrsr.identities.roster import IdentityRange
from lrsr.paths import config_folder
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.picture import Picture
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.sitting import Sitting
from lrsr.pictures.to_folder import RenderSettings, render_to_folder
from lrsr.presets import preset, presets
from lrsr.recognition import Engine
from lrsr.recognition.settings import RecognitionSettings
from lrsr.rendering.scene import Film, Quality, Scene
from lrsr.sr import Bicubic, Correlation, Mean

NAN = np.nan
LANDMARKS = torch.tensor([[8.0, 10], [16, 10], [12, 14], [9, 18], [15, 18]])


def pooled(pooling: Any = "mean", frames: int = 3, scale: int = 2) -> Pooled:
    return Pooled(frames, Bicubic(scale), "pooled_1", pooling, "Pooled")


def fused(frames: int = 3, scale: int = 2, after: int = 1) -> Fused:
    return Fused(frames, Bicubic(after), "fused_1", Mean(scale, Correlation("shift")))


def several(*words: str) -> dict[str, Several]:
    with initialize_config_dir(str(config_folder()), version_base="1.3"):
        config = compose("eval", ["experiment=frames", *words])
    found = read_several(config)
    assert all(isinstance(one, Several) for one in found.values())
    return found  # type: ignore[return-value]  # as was said


def burst(frames: int, seed: int = 0) -> Picture:
    generator = torch.Generator().manual_seed(seed)
    base = torch.rand(1, 3, 6, 6, generator=generator)
    smooth = torch.nn.functional.interpolate(base, size=(24, 24), mode="bicubic")[0].clamp(0, 1)
    first, *later = (
        Picture(smooth, f"p{seed}", LANDMARKS + number, "a test") for number in range(frames)
    )
    return replace(first, later=tuple(later))


def test_the_mean_of_embeddings_is_as_long_as_they_are() -> None:
    rows = np.array([[[1.0, 0.0], [0.0, 1.0], [NAN, NAN]], [[NAN, NAN]] * 3])
    found = pooled().pool(rows, np.full((2, 3), NAN))
    np.testing.assert_allclose(found, [[np.sqrt(0.5), np.sqrt(0.5)], [NAN, NAN]])
    longer = pooled(frames=2).pool(np.array([[[2.0, 0.0], [4.0, 0.0]]]), np.zeros((1, 2)))
    np.testing.assert_allclose(longer, [[3.0, 0.0]])
    opposite = pooled(frames=2).pool(np.array([[[1.0, 0.0], [-1.0, 0.0]]]), np.zeros((1, 2)))
    assert np.isnan(opposite).all()  # it says nothing


def test_the_best_frame_is_that_of_the_highest_score() -> None:
    rows = np.arange(12.0).reshape(2, 3, 2)
    scores = np.array([[0.2, 0.9, NAN], [NAN, NAN, NAN]])
    assert pooled("best").pool(rows, scores).tolist() == [[2.0, 3.0], [6.0, 7.0]]
    assert surest(scores)[1].tolist() == [1, 0]


def test_a_method_sees_as_many_frames_as_it_takes() -> None:
    bursts = [burst(4), burst(4, seed=1)]
    views, points = see(pooled(frames=3), bursts)
    assert views.shape == (2, 3, 3, 48, 48)
    torch.testing.assert_close(points[0, :, 0, 0], 2 * (8 + torch.arange(3.0) + 0.5) - 0.5)
    views, points = see(fused(frames=2, scale=2, after=2), bursts)
    assert views.shape == (2, 1, 3, 96, 96)
    torch.testing.assert_close(points[1, 0], 4 * (LANDMARKS + 0.5) - 0.5)
    views, points = see(Bicubic(2), bursts)
    assert (views.shape, points.shape) == ((2, 1, 3, 48, 48), (2, 1, 5, 2))
    with pytest.raises(InputError, match="has 4 frames: wanted 5"):
        see(pooled(frames=5), bursts)


def test_one_frame_is_the_single_picture() -> None:
    bursts = [burst(4), burst(4, seed=1)]
    alone = see(Bicubic(2), bursts)
    for method in (pooled(frames=1), pooled("best", frames=1), fused(frames=1)):
        for mine, theirs in zip(see(method, bursts), alone, strict=True):
            torch.testing.assert_close(mine, theirs, atol=1e-5, rtol=0)


def test_methods_say_what_they_are() -> None:
    assert fused().label == "Mean of 3"
    assert fused(1, 1, 4).label == "Mean of 1 + Bicubic 4"
    assert (fused(1, 2, 4).scale, pooled(scale=4).scale) == (8, 4)
    assert not fused().learned
    assert Fused(1, preset("sr", "srcnn2"), "x_1", Mean(2)).learned
    for method in (fused(), pooled()):
        told = json.loads(json.dumps(method.describe()))
        assert (told["frames"], told["upscaler"]["kind"]) == (3, "bicubic")


@pytest.mark.parametrize("make", [fused, pooled])
def test_no_frame_is_refused(make: Any) -> None:
    with pytest.raises(InputError, match="frames=0: wanted at least 1"):
        make(frames=0)


def test_there_is_no_other_pooling() -> None:
    with pytest.raises(InputError, match="pooling=worst: wanted mean or best"):
        pooled("worst")


def test_every_fusion_has_every_number_of_frames() -> None:
    found = several("frames=[1,4]")
    assert list(found) == [f"{name}_{n}" for name in several_names() for n in (1, 4)]
    assert {one.alone for one in found.values()} == {f"{name}_1" for name in several_names()}
    assert {one.scale for one in found.values()} == {4}
    assert found["best_frame_4"].describe()["pooling"] == "best"


def several_names() -> list[str]:
    return ["mean", "shift_and_add", "learned", "embedding_mean", "best_frame"]


def test_the_oracle_is_the_only_other() -> None:
    assert sorted([*several_names(), "mean_true"]) == presets("fusion")
    told = several("fusions=mean_true", "frames=2")["mean_true_2"].describe()["fusion"]
    assert told["registration"]["by"] == "true landmarks"  # type: ignore[index]  # plain values


def test_a_fusion_is_changed_and_added_on_its_own() -> None:
    words = ["+fusion.mean.upscaler=srcnn2", "+fusion.mean.fusion.scale=1"]
    added = "+fusion.mine={like: embedding_mean, upscaler: base}"
    found = several("fusions=[mean,mine]", "frames=3", *words, added)
    assert list(found) == ["mean_3", "mine_3"]
    assert (found["mean_3"].label, found["mean_3"].scale) == ("Mean of 3 + SR 2", 2)
    assert (found["mine_3"].scale, found["mine_3"].alone) == (1, "mine_1")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["fusions=[median]"], "fusion=median: there is none; did you mean mean"),
        (["+fusion.mean.upscaler=none"], "sr=none: there is none"),
        (["+fusion.mean.fusion.size=2"], "fusion.mean: .*'size'"),
        (["fusions=[]"], r"frames=\[1, 2, 4, 8\]: wanted fusions=\[...\] besides"),
        (["frames=[]"], r"frames=\[\]: wanted at least one number"),
        (["frames=[0]"], "frames=0: wanted at least 1"),
        (["+fusion.other.upscaler=base"], "fusions=.*: wanted other among them"),
        (["+fusion.mean=3"], "fusion.mean=3: wanted fusion.mean.SETTING="),
    ],
    ids=str,
)
def test_a_wrong_setting_is_named(words: list[str], says: str) -> None:
    with pytest.raises(InputError, match=says):
        several(*words)


class NoisyMaker(PaintedMaker):
    """Paints with so much noise that one frame is not enough; every frame has noise of its own."""

    def render(self, head: Any, recipe: Recipe) -> Any:
        light = super().render(head, recipe)
        noise = torch.rand(light.image.shape, generator=torch.Generator().manual_seed(recipe.seed))
        return replace(light, image=0.04 * light.image + 0.9 * noise)


PEOPLE = IdentityRange(count=10)
SCENE = Scene(preset("lighting", "frontal"))
QUALITY = Quality(samples_per_pixel=4, texture_size=64)
STILL = Mean(1, Correlation("shift", finer=1, least=0))
DESIGN = Design(
    name="bursts",
    question="Do several frames tell more?",
    conditions=(Condition(1, SCENE, "none", 8.0),),
    upscalers={
        "base": Bicubic(1),
        "pooled_1": pooled(frames=1, scale=1),
        "pooled_6": pooled(frames=6, scale=1),
        "fused_6": Fused(6, Bicubic(2), "fused_1", STILL),
    },
    people=PEOPLE,
    quality=QUALITY,
    seed=0,
    gallery=Sitting(PEOPLE, SCENE, Film(32.0), QUALITY, "gallery"),
    camera=Camera(),
)


def test_several_frames_of_noise_tell_more_than_one(tmp_path: Path, tone_model: Path) -> None:
    cache = RenderCache(tmp_path / "cache")
    trial = Trial(DESIGN, cache, Engine(tone_model), NoisyMaker(), progress=False)
    assert trial.render() == 10 * (1 + 6 + 1)
    (outcome,) = trial.outcomes()
    rows = {row["method"]: row for row in outcome.rows}
    assert {name: row["frames"] for name, row in rows.items()} == {
        **{"base": 1, "pooled_1": 1, "pooled_6": 6, "fused_6": 6}
    }
    assert rows["pooled_1"]["auc"] == rows["base"]["auc"] < 0.9
    assert rows["pooled_6"]["auc"] > rows["base"]["auc"] + 0.05
    assert rows["pooled_6"]["psnr_y_db"] is None
    assert rows["fused_6"]["psnr_y_db"] > 0
    assert [(test["method"], test["against"]) for test in outcome.comparisons] == [
        ("pooled_1", "base"),
        ("pooled_6", "base"),
        ("pooled_6", "pooled_1"),
        ("fused_6", "base"),
    ]
    assert [*outcome.panel.pictures] == [
        "Gallery",
        "Probe",
        "Mean of 6 + Bicubic 2",
        "Reference",
    ]


def test_bursts_of_a_folder_give_the_rows_of_the_people_they_show(
    tmp_path: Path, tone_model: Path
) -> None:
    cache, maker = RenderCache(tmp_path / "cache"), NoisyMaker()
    sitting = Sitting(PEOPLE, SCENE, Film(8.0), QUALITY.at(8.0))
    probes = tmp_path / "probes"
    settings = RenderSettings(probes, sitting, Camera(), scales=(1, 2), frames=6)
    render_to_folder(settings, cache, progress=False, maker=maker)
    condition = Condition(1, None, "none", 8.0, "frontal", "frontal")
    read = replace(DESIGN, conditions=(condition,), probes_folder=probes)
    rows = [
        next(iter(Trial(one, cache, Engine(tone_model), maker, progress=False).outcomes())).rows
        for one in (DESIGN, read)
    ]
    of_folder = {"setting": "photographs", "camera": "", "skin": ""}
    assert rows[1] == [row | of_folder for row in rows[0]]


def test_the_best_frame_needs_a_detector() -> None:
    methods = {"best_6": pooled("best", frames=6)}
    with pytest.raises(
        InputError, match=r"recognition\.landmarks=shared: wanted both or own: best_6"
    ):
        replace(DESIGN, upscalers=methods, recognition=RecognitionSettings(landmarks=("shared",)))
