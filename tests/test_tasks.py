"""What a task refuses before it does anything."""

from types import SimpleNamespace

import pytest
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
    with pytest.raises(InputError, match=r"photographs in probes\.folder are as they are"):
        tasks._refuse_unread(config)


@pytest.mark.parametrize(
    ("kind", "word", "told"),
    [
        ("gallery", "pose=left", True),
        ("gallery", "ipd_px=11", True),
        ("gallery", "gallery.pose=left", False),
        ("probe", "gallery.pose=left", True),
        ("probe", "pose=left", False),
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
