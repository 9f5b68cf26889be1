"""Every setting of every command, given another kind of value, is refused in a line that names it.

Nothing is rendered, trained or written: what a command calls last is replaced.
"""

import functools
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NoReturn

import hydra.utils
import pytest
import torch
from fakes.configurations import composed
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from lrsr import presets, tasks
from lrsr.failures import explain
from lrsr.pictures import sitting
from lrsr.pictures.image_files import write_png
from lrsr.sr import loading
from lrsr.training import run

COMMANDS = {
    "render": [
        *("camera=axis_p1435le", "lighting=lamp", "standpoint=scface_far", "rendering=subsurface"),
        *("expression=grin", "out=pictures"),
    ],
    "render-gallery": ["kind=gallery", "out=pictures"],
    "render-lens": ["lens=double_gauss", "lighting=above", "out=pictures"],
    "render-spectral": ["camera=nikon_d5100", "out=pictures"],
    "eval": ["options=[1,6]"],
    "eval-case": ["experiment=case", "identities.count=20"],
    "compare": ["files=[a.png,b.png]"],
    "score": ["files=[scores.csv]"],
    "identities": [],
    "identities-export": ["export=meshes"],
    "fit-camera": ["images=."],
    "models": ["action=verify"],
    "upscale": ["images=[a.png]", "out=larger", "format=png", "around_px=8"],
    "train-srcnn": ["train=srcnn4x"],
    "train-edsr": [
        *("train=edsr2x", "loss=[identity,adversarial]"),
        *("module.arguments.blocks=1", "module.arguments.features=8"),
    ],
    "train-arcface": ["train=arcface"],
    "train-mixed-resolution": ["train=mixed_resolution"],
    "train-position-map": ["train=position_map"],
    "train-images": ["train=srcnn2x", "data=images", "data.root=shown", "degradation=bsrgan"],
    "train-mixed": [
        *("train=srcnn2x_camera", "data=mixed", "data.root=shown", "data.crop_px=64"),
    ],
}
SHARED = {"identities", "rendering", "lens", "standpoint", "paths", "seed", "processes"}
"""What is read alike in every command, and tried in the first."""
BUILT_ALIKE = {"pose", "lighting", "expression", "another_day", "burst"}
"""Built alike in every command: tried whole in the first, by one setting in those that read it."""
OF_RENDER = ("kind", "ipd_px", "frames", "scales", "compression", "png16", "out")
"""Of the command, whatever lens and camera: tried in the first."""
OF_TRAINING = ("trainer", "resume", "camera")
"""Of the command, whatever network: tried with srcnn."""
UNREAD = {
    "render": {"gallery", "paths.run", "paths.runs"},  # of kind=probe; it writes into out
    "render-lens": {"gallery", *OF_RENDER},
    "render-spectral": {"gallery", *OF_RENDER, "camera.sensor", "camera.processing"},
    "render-gallery": {
        *("pose", "lighting", "expression", "another_day", "ipd_px", "compression", "burst"),
    },
    "identities": {"pose", "lighting", "expression", "another_day", "ipd_px", "export"},
    "identities-export": {
        *("gallery", "recognition", "encoder", "smallest_angle_deg", "most_redraws"),
        *("paths.run", "paths.runs"),  # it writes into export
    },
    "eval-case": {
        *("sr", "recognition", "gallery", "burst", "expression", "another_day"),  # tried in eval
        *("probes", "conditions", "options", "fusions", "fusion", "frames", "lpips"),
        *("axes", "against", "shard", "shards", "details", "references"),  # of others
        *("pose", "lighting", "camera"),  # tried in render
        *("methods", "level", "bootstrap", "save_scores", "calibration", "name", "question"),
    },
    "compare": {"paths", "sr", "recognition"},
    "upscale": {"paths.run", "paths.runs"},  # it writes into out
    "fit-camera": {"camera"},  # when the pictures were read
    "models": {"paths"},
    "train-edsr": {*OF_TRAINING},
    "train-arcface": {*OF_TRAINING},
    "train-images": {"expression", "another_day", "callbacks", "module", *OF_TRAINING},
    "train-mixed": {"callbacks", "module", *OF_TRAINING, "degradation"},  # tried with images
    "train-position-map": {
        *("expression", "another_day", "callbacks", *OF_TRAINING),
        *("degradation.background", "degradation.occlusion", "degradation.blur"),  # with arcface
        *("degradation.colour", "degradation.misalignment", "data.variety.named_share"),
    },
}
OF_OTHERS = {
    *("expression.name", "identities.roster"),  # lrsr.identities takes any text for a name
    *("logger", "trainer.devices", "module.scheduler", "module.optimizer.weight_decay"),
}
WORD, LIST, NAMES, NUMBER = "no-such-word", [1, 2], {"a": 1}, 7
RIGHT: dict[str, list[Any]] = {
    "names": [WORD],  # one word is a list of one
    "standpoint.distance_m": [None],
    "standpoint.height_m": [None],
    "files": [WORD],  # one is a list of one
    "quality": [WORD],
    "images": [WORD],  # the same
    "tile_px": [None],
    "around_px": [None],
    "camera.stored.qualities": [LIST],  # compressed twice
    "data.crop_px": [None],
}


class DoneError(Exception):
    """All settings were taken."""


def stop(*_: object, **__: object) -> NoReturn:
    raise DoneError


def stop_at_the_trainer(*_: object, folder: Path, trainer: Any, **__: object) -> NoReturn:
    run._build_trainer(folder, trainer, [], [])
    stop()


@pytest.fixture(autouse=True)
def _nothing_is_done(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    for last in (
        "pictures.to_folder.render_to_folder",
        "calibration.from_pictures.fit_to_folder",
        "experiments.verification.Verification.run",
        "experiments.case.Case.run",
        "experiments.pair.PairComparison.run",
        "experiments.people.Uniqueness.run",
        "experiments.scoring.Scoring.run",
        "pictures.export.export_to_folder",
        "recognition.store.verify",
        "experiments.upscaling.Upscaling.run",
        "training.mixed_resolution.MixedResolution.train",
    ):
        monkeypatch.setattr(f"lrsr.{last}", stop)
    monkeypatch.setattr("lrsr.training.run.train", stop_at_the_trainer)
    for lessons in ("rendered.Rendered", "pairs.Pairs"):
        monkeypatch.setattr(f"lrsr.training.{lessons}.about", lambda _: {})
    for number in range(2):
        write_png(tmp_path / "shown" / f"{number}.png", torch.zeros(3, 40, 40))
    monkeypatch.setattr(tasks, "write_provenance", lambda *_: None)
    monkeypatch.setattr(loading, "read_weights", functools.cache(loading.read_weights))
    monkeypatch.setattr(presets, "preset", as_they_are)
    monkeypatch.setattr(hydra.utils, "instantiate", made_once)
    monkeypatch.setattr(sitting, "section", read_once)
    of_hydra = SimpleNamespace(
        job=SimpleNamespace(config_name="command", num=0),
        mode=RunMode.RUN,
        overrides=SimpleNamespace(task=[]),
        runtime=SimpleNamespace(choices={"sr": "base"}),
    )
    monkeypatch.setattr(HydraConfig, "get", lambda: of_hydra)


PRESET, BUILT = presets.preset, functools.cache(presets.preset)


def as_they_are(group: str, name: str, /, **changes: Any) -> Any:
    """A preset, built once where nothing of it is changed: most are not what a case is about."""
    return PRESET(group, name, **changes) if changes else BUILT(group, name)


INSTANTIATE, MADE = hydra.utils.instantiate, dict[str, Any]()


def made_once(node: Any, **how: Any) -> Any:
    """Build what a case has left as it was once for all cases."""
    plain = OmegaConf.to_container(node, resolve=True) if OmegaConf.is_config(node) else node
    key = repr((plain, how))
    if key not in MADE:
        MADE[key] = INSTANTIATE(node, **how)
    return MADE[key]


SECTION, READ = sitting.section, dict[str, Any]()


def read_once(schema: type, config: DictConfig, key: str) -> Any:
    """Read a section that a case has left as it was once for all cases."""
    asked = f"{schema} {config[key]}"
    if asked not in READ:
        READ[asked] = SECTION(schema, config, key)
    return READ[asked]


def leaves(node: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    if isinstance(node, dict) and node:
        for key, inner in node.items():
            if not key.startswith("_"):
                yield from leaves(inner, (*path, key))
    else:
        yield path, node


def of_other_kinds(value: object) -> list[Any]:
    if isinstance(value, bool):
        return [WORD, NUMBER, LIST]
    if isinstance(value, int | float):
        return [WORD, LIST, NAMES, None, True]
    if isinstance(value, str):
        return [LIST, NAMES, True]
    if isinstance(value, list):
        return [WORD, NAMES, True, [NAMES]]
    return [NAMES, True] if value is None else [WORD, LIST]


def attempt(command: str, config: DictConfig, word: str) -> str | None:
    """Return the line that the command refuses with; None if it takes everything."""
    name = command.split("-")[0] if command != "fit-camera" else command
    task = getattr(tasks, f"run_{name.replace('-', '_')}")
    try:
        task(config)
    except DoneError:
        return None
    except Exception as error:
        status, line = explain(error, [word])
        return line if status == 2 else f"fault: {line}"
    raise AssertionError("the command went past its last step")


def is_below(key: str, others: set[str]) -> bool:
    return any(key == other or key.startswith(f"{other}.") for other in others)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_value_of_another_kind_is_refused_by_name(command: str) -> None:
    name = command if command == "fit-camera" else command.split("-")[0]
    count = 20 if command == "fit-camera" else 2
    nobody = ("score", "models", "upscale", "compare", "eval-case")
    people = [] if command in nobody else [f"identities.count={count}"]
    config = composed(name, *COMMANDS[command], *people)
    OmegaConf.set_struct(config, False)
    plain = OmegaConf.to_container(config, resolve=False)
    assert attempt(command, config, "") is None
    skipped = UNREAD.get(command, set()) | OF_OTHERS
    if command != "render":
        skipped |= SHARED - ({"lens"} if command == "render-lens" else set())
    wrong = []
    for path, value in leaves(plain):
        key = ".".join(path)
        if is_below(key, skipped) or (isinstance(value, str) and "${" in value):
            continue
        if command != "render":
            skipped |= BUILT_ALIKE & {path[0]}
        for other in of_other_kinds(value):
            if other in RIGHT.get(key, ()):
                continue
            section = functools.reduce(DictConfig.__getitem__, path[:-1], config)
            section[path[-1]] = other
            line = attempt(command, config, f"{key}={other}")
            section[path[-1]] = value
            if line is None or line.startswith("fault") or not says(line, path):
                wrong.append(f"{key}={other}: {line}")
    assert not wrong, "\n".join(wrong)


def says(line: str, path: tuple[str, ...]) -> bool:
    """A part of a list, or a preset chosen by a word, is told by what it is part of."""
    presets = {"methods": "sr=", "gallery_lighting": "lighting", "probe_lighting": "lighting"}
    parts = [*path[-2:], presets.get(path[-1], path[-1])]
    return "\n" not in line and any(part.rstrip("s") in line for part in parts)
