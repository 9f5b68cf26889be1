"""Every file of ``lrsr train`` composes and builds what it names, and nothing in it is dropped."""

from functools import cache
from pathlib import Path
from typing import Any

import pytest
from fakes import configurations
from fakes.lessons import draw_pictures
from lightning.pytorch.loggers import CSVLogger
from omegaconf import DictConfig, OmegaConf

from lrsr.errors import InputError
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.population import Population
from lrsr.identities.roster import Roster, write_roster
from lrsr.paths import config_folder
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.image_files import write_png
from lrsr.presets import build, node_of
from lrsr.tasks import _those_of
from lrsr.training.lessons import read_lessons
from lrsr.training.progress import Progress
from lrsr.training.shrinking.bsrgan import Bsrgan
from lrsr.training.shrinking.clean import Clean
from lrsr.training.shrinking.one_camera import OneCamera
from lrsr.training.shrinking.random_cameras import RandomCameras

NAMES = (
    *("srcnn2x", "srcnn3x", "srcnn4x", "srcnn2x_camera", "srcnn4x_camera", "edsr2x", "edsr4x"),
    *(
        f"{name}{scale}x"
        for name in ("srcnn955_", "fsrcnn", "imdn", "sparnet")
        for scale in (2, 3, 4)
    ),
    *("fsrcnn2x_camera", "fsrcnn4x_camera", "imdn4x_camera"),
    *("fusion4x", "arcface", "mixed_resolution", "position_map"),
)


def composed(name: str, *overrides: str) -> DictConfig:
    words = [f"train={name}", "identities.count=4", "paths.run=x", *overrides]
    return configurations.composed("train", *words)


def lessons(name: str, folder: Path, *overrides: str) -> Any:
    return read_lessons(composed(name, *overrides), RenderCache(folder))


@cache
def renderings(name: str, change: str = "seed=0") -> object:
    """What the renderings of a network's lessons depend on; a preset takes the place of another."""
    group, _, option = change.partition("=")
    if not (config_folder() / group).is_dir():
        return lessons(name, Path("nowhere"), change).about()["renderings"]
    config = composed(name)
    OmegaConf.update(config, group.replace("/", "."), node_of(group, option, {}), merge=False)
    return read_lessons(config, RenderCache(Path("nowhere"))).about()["renderings"]


def test_every_network_is_tested() -> None:
    assert {path.stem for path in Path(config_folder(), "train").glob("*.yaml")} == set(NAMES)


@pytest.mark.parametrize(
    ("name", "data", "wish"),
    [
        ("srcnn2x", "faces", "rendered or images or mixed"),
        ("edsr2x", "bursts", "rendered or images or mixed"),
        ("arcface", "encounters", "faces"),
        ("mixed_resolution", "rendered", "encounters"),
    ],
)
def test_lessons_of_something_else_are_refused(
    name: str, data: str, wish: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=f"data={data}: wanted {wish}, from which this network"):
        lessons(name, tmp_path, f"data={data}")


@pytest.mark.parametrize("name", NAMES)
def test_every_network_and_its_lessons_are_built(name: str, tmp_path: Path) -> None:
    config = composed(name, "seed=3")
    data = read_lessons(config, RenderCache(tmp_path))
    assert [person.id for person in data.people][::3] == ["train-00000", "train-00003"]
    assert [person.split for person in data.validation_people] == ["validation"] * 2
    module = build(config.module, "module")
    assert module.seed == 3
    if name != "mixed_resolution":  # which has a closed form
        assert module.make_optimizer(module.parameter_groups()).param_groups[0]["lr"] > 0


@pytest.mark.parametrize(("name", "epochs", "scale"), [("srcnn2x", 160, 2), ("srcnn4x", 40, 4)])
def test_srcnn_is_trained_as_in_the_paper(name: str, epochs: int, scale: int) -> None:
    config = composed(name)
    assert (config.trainer.max_epochs, config.data.batch_size) == (epochs, 128)
    module = build(config.module, "module")
    assert (module.card.scale, config.data.scale) == (scale, scale)
    optimizer = module.make_optimizer(module.parameter_groups())
    assert sorted(group["lr"] for group in optimizer.param_groups) == [1e-4, 1e-3]


@pytest.mark.parametrize(
    "name",
    ["srcnn2x", "arcface", "mixed_resolution", "position_map"],
    ids=["pairs", "faces", "encounters", "maps"],
)
@pytest.mark.parametrize(
    "changed",
    [
        "identities.start=5",
        "identities.sex=female",
        "rendering.samples_per_pixel=7",
        "rendering.texture_size=64",
        "rendering.max_depth=2",
        "rendering/skin=jensen_skin1",
        "lens=single",
        "standpoint=scface_far",
        "expression=smile",
        "another_day=hair",
        "camera.supersampling=2",
        "seed=1",
    ],
)
def test_every_setting_of_the_renderings_counts(name: str, changed: str) -> None:
    if changed.startswith("camera"):
        changed = f"+{changed}"
    assert renderings(name, changed) != renderings(name)


def test_names_become_values(tmp_path: Path) -> None:
    data = lessons("srcnn2x", tmp_path, "data.poses=[up]", "data.ipd_px=[8,11]", "data.views=8")
    recipes = data.recipes(data.people, 1)
    assert {recipe.scene.pose.pitch_deg for recipe in recipes} == {20.0}
    assert {recipe.film.ipd_px for recipe in recipes} == {8.0, 11.0}


def test_one_value_is_a_list_of_one(tmp_path: Path) -> None:
    words = ["data.poses=left", "data.lightings=above", "data.ipd_px=9", "data.views=1"]
    data = lessons("srcnn2x", tmp_path, *words, "degradation.compressions=heavy")
    ((scene, ipd_px),) = data.conditions
    assert (scene.pose.name, scene.lighting.name, ipd_px) == ("left", "above", 9.0)
    assert [camera.compression for camera in data.cameras] == ["heavy"]


def test_who_is_cast_is_who_is_learned(tmp_path: Path) -> None:
    women = Population("female")
    roster = Roster("train", 0, 4, women, RECIPE_VERSION, "dlib", 11.2, {3: 1})
    path = write_roster(tmp_path / "roster.json", roster)
    words = ["identities.sex=female", f"identities.roster={path}"]
    data = lessons("srcnn2x", tmp_path, *words)
    assert [person.draw for person in data.people] == [0, 0, 0, 1]
    assert {p.population for p in [*data.people, *data.validation_people]} == {women}
    with pytest.raises(InputError, match="covers train 0 to 3"):
        lessons("srcnn2x", tmp_path, *words, "identities.count=5")


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("data.views=many", "data.views=many: wanted a whole number"),
        ("data.ipd_px=wide", "data.ipd_px=wide: wanted a number"),
        ("identities.split=test", "identities.split=test: wanted train, to learn from"),
        ("data.validation_fraction=0", "data.validation_fraction=0.0: wanted a number > 0"),
        ("data.poses=[lefft]", "pose=lefft: there is none; did you mean left"),
        ("+data.ipd=3", "data: .*unexpected keyword argument 'ipd'"),
        ("data.validation_count=0", "data.validation_count=0: wanted at least 1"),
        ("data=images", "data.root must be given: add data.root="),
        ("degradation=photographs", "degradation._target_=.*for recognition=arcface"),
    ],
)
def test_a_wrong_setting_is_one_line(word: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        lessons("srcnn2x", tmp_path, word)


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        ([], OneCamera),
        (["data=images", "data.root=x"], Clean),
        (["data=mixed", "data.root=x"], OneCamera),
        (["degradation=bsrgan"], Bsrgan),
        (["data=images", "data.root=x", "degradation=random_cameras"], RandomCameras),
    ],
    ids=["rendered", "images", "mixed", "bsrgan", "images, random cameras"],
)
def test_the_degradation_follows_from_the_data_unless_it_is_chosen(
    words: list[str], wanted: type
) -> None:
    assert isinstance(build(composed("srcnn2x", *words).degradation, "degradation"), wanted)


@pytest.mark.parametrize("scale", [2, 4])
def test_camera_aware_networks_see_random_cameras_of_any_data(scale: int) -> None:
    for data in ([], ["data=images"], ["data=mixed"]):
        config = composed(f"srcnn{scale}x_camera", *data)
        assert config.module.scale == scale
        assert config.degradation._target_.endswith("RandomCameras")


@pytest.fixture
def pictures(tmp_path: Path) -> Path:
    for number, picture in enumerate(draw_pictures(3, 40, seed=0)):
        write_png(tmp_path / "pictures" / f"{number}.png", picture)
    return tmp_path / "pictures"


def test_a_folder_of_pictures_is_read_without_people(pictures: Path, tmp_path: Path) -> None:
    data = lessons("srcnn3x", tmp_path, "data=images", f"data.root={pictures}", "data.pictures=1")
    assert (data.scale, len(data.learned), len(data.judged)) == (3, 1, 1)
    data.setup("fit")
    assert next(iter(data.train_dataloader()))[0].shape == (1, 1, 33, 33)


def test_mixed_lessons_take_the_settings_of_both(pictures: Path, tmp_path: Path) -> None:
    words = ["data=mixed", f"data.root={pictures}", "data.ipd_px=9", "data.views=1"]
    words += ["data.rendered_share=0.3", "data.validation_count=5", "data.crop_px=null"]
    data = lessons("srcnn2x", tmp_path, *words)
    assert (data.rendered.ipd_px, data.images.crop_px, data.rendered_share) == ([9.0], None, 0.3)
    assert [len(data.rendered.validation_people), len(data.images.judged)] == [5, 1]
    with pytest.raises(InputError, match=r"data\.crop: no setting of data=mixed"):
        lessons("srcnn2x", tmp_path, *words, "+data.crop=3")


def test_so_many_people_validate_however_many_are_learned(tmp_path: Path) -> None:
    data = lessons("srcnn2x", tmp_path, "data.validation_count=7")
    assert len(data.validation_people) == 7


def test_callbacks_loggers_and_trainer_are_built(tmp_path: Path) -> None:
    config = composed("srcnn4x")
    assert [type(callback) for callback in _those_of(config, "callbacks")] == [Progress]
    assert _those_of(composed("srcnn4x", "callbacks.progress=null"), "callbacks") == []
    logger = build(config.logger, "logger")["csv"](save_dir=str(tmp_path))
    assert isinstance(logger, CSVLogger)
    assert Path(logger.log_dir) == tmp_path / "csv" / "version_0"
    trainer = build(config.trainer, "trainer").keywords
    assert (trainer["max_epochs"], trainer["precision"]) == (40, "auto")
