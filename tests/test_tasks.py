"""What a task refuses before it does anything."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from fakes.configurations import composed
from omegaconf import OmegaConf

from lrsr import tasks
from lrsr.errors import InputError


@pytest.mark.parametrize(
    ("folders", "word", "refused"),
    [
        ({"probes": "a"}, "ipd_px=11", True),
        ({"probes": "a"}, "camera.exposure_ev=1", True),
        ({"probes": "a"}, "+conditions.7.pose=left", True),
        ({"probes": "a"}, "identities.count=7", False),
        ({"probes": "a", "gallery": "b"}, "identities.count=7", True),
        ({"probes": "a", "gallery": "b"}, "rendering/skin=tone", True),
        ({"probes": "a", "gallery": "b"}, "methods=[base]", False),
        ({"gallery": "b"}, "ipd_px=11", False),
        ({"gallery": "b"}, "gallery.folder=b", False),
        ({"gallery": "b"}, "gallery.pose=left", True),
        ({"probes": "a"}, "gallery.pose=left", False),
        ({}, "ipd_px=11", False),
    ],
)
def test_what_photographs_make_needless_is_refused(
    folders: dict[str, str], word: str, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    runtime = SimpleNamespace(overrides=SimpleNamespace(task=[word]))
    monkeypatch.setattr("hydra.core.hydra_config.HydraConfig.get", lambda: runtime)
    config = OmegaConf.create({key: {"folder": folders.get(key)} for key in ("probes", "gallery")})
    if not refused:
        tasks._refuse_unread(config)
        return
    folder = next(iter(folders))
    with pytest.raises(InputError, match=rf"photographs in {folder}\.folder are as they are"):
        tasks._refuse_unread(config)


@pytest.mark.parametrize(
    ("kind", "word", "told"),
    [
        ("gallery", "pose=left", True),
        ("gallery", "ipd_px=11", True),
        ("gallery", "gallery.pose=left", False),
        ("gallery", "rendering.samples_per_pixel=8", True),
        ("gallery", "rendering.max_depth=3", False),
        ("probe", "gallery.pose=left", True),
        ("probe", "pose=left", False),
        ("probe", "rendering.samples_per_pixel=8", False),
    ],
)
def test_words_that_change_nothing_are_told(
    kind: str,
    word: str,
    told: bool,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    runtime = SimpleNamespace(overrides=SimpleNamespace(task=["out=x", word]))
    monkeypatch.setattr("hydra.core.hydra_config.HydraConfig.get", lambda: runtime)
    tasks._tell_unread(kind)
    assert (f"{word.partition('=')[0]} changes nothing where kind={kind}" in caplog.text) == told


class Reader:
    """An experiment that reads the seed alone, and more where it is told so."""

    @staticmethod
    def unread(config: Any) -> tuple[str, ...]:
        return ("camera",) if config.seed == 0 else ()

    @classmethod
    def from_config(cls, config: Any) -> "Reader":
        raise InputError("from_config was reached")


@pytest.mark.parametrize(("seed", "says"), [(0, "camera.exposure_ev: "), (1, "from_config")])
def test_an_experiment_may_tell_by_the_configuration_what_it_does_not_read(
    seed: int, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    runtime = SimpleNamespace(overrides=SimpleNamespace(task=["camera.exposure_ev=1"]))
    monkeypatch.setattr("hydra.core.hydra_config.HydraConfig.get", lambda: runtime)
    monkeypatch.setattr("hydra.utils.get_class", lambda _: Reader)
    with pytest.raises(InputError, match=says):
        tasks.run_eval(composed("eval", f"seed={seed}"))


def test_a_pair_is_compared_by_the_method_that_was_chosen(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    chosen = SimpleNamespace(runtime=SimpleNamespace(choices={"sr": "srcnn4"}))
    monkeypatch.setattr("hydra.core.hydra_config.HydraConfig.get", lambda: chosen)
    result: dict[str, Any] = {"pictures": [], "comparisons": []}

    def read(config: Any, method: str) -> Any:
        assert method == "srcnn4"
        return SimpleNamespace(run=lambda: result, out=Path("pair.json"))

    monkeypatch.setattr("lrsr.experiments.pair.PairComparison.from_config", read)
    config = composed("compare", "files=[a.png,b.png]")
    assert tasks.run_compare(config) == Path("pair.json")
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("task", "words"),
    [
        (tasks.run_render, ["render", "out=probes"]),
        (tasks.run_identities, ["identities"]),
        (tasks.run_train, ["train", "train=srcnn2x"]),
    ],
    ids=["render", "identities", "train"],
)
def test_photographs_are_enrolled_by_eval_alone(task: Any, words: list[str]) -> None:
    config = composed(*words, "identities.gallery=photograph")
    with pytest.raises(InputError, match=r"identities\.gallery=photograph: wanted render"):
        task(config)
