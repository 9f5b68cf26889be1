from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir

from lrsr.errors import InputError
from lrsr.paths import config_folder
from lrsr.recognition.detection.enlargement import Enlargement
from lrsr.recognition.memory import Memory
from lrsr.recognition.settings import RecognitionSettings


def read(*words: str, command: str = "eval") -> RecognitionSettings:
    with initialize_config_dir(str(config_folder()), version_base="1.3"):
        return RecognitionSettings.from_config(compose(command, list(words)))


def test_an_experiment_has_landmarks_of_both_sources() -> None:
    assert read() == RecognitionSettings(landmarks=("shared", "own"))
    assert read(command="demo").landmarks == ("shared", "own")
    assert read(command="identities").landmarks == ("shared",)


def test_every_setting_is_read() -> None:
    words = [
        *("recognition.model=a.onnx", "recognition.detector=b.onnx", "recognition.landmarks=own"),
        *("recognition.alignment=deepface", "recognition.fallback=whole_image"),
        *("recognition.enlargement.border=0.5", "recognition.enlargement.shorter_px=1024"),
        "recognition.score_threshold=0.9",
    ]
    assert read(*words) == RecognitionSettings(
        Path("a.onnx").resolve(),
        ("own",),
        Path("b.onnx").resolve(),
        Enlargement(border=0.5, shorter_px=1024),
        0.9,
        "deepface",
        "whole_image",
    )


def test_an_engine_is_as_the_settings_say(tiny_model: Path, tmp_path: Path) -> None:
    rule = Enlargement(shorter_px=100)
    settings = RecognitionSettings(tiny_model, ("own",), None, rule, 0.7, "eyes", "whole_image")
    (engine,) = settings.engines(Memory(tmp_path)).values()
    told = engine.describe()
    assert (told["alignment"], told["fallback"], told["model"]) == (
        "eyes",
        "whole_image",
        "tiny.onnx",
    )
    assert (engine.detector.enlargement, engine.detector.score_threshold) == (rule, 0.7)


def test_a_missing_detector_is_refused_before_anything_is_done(
    tiny_model: Path, tmp_path: Path
) -> None:
    settings = RecognitionSettings(tiny_model, ("own",), tmp_path / "gone.onnx")
    with pytest.raises(InputError, match=r"gone\.onnx is missing"):
        settings.engines()
    assert settings.__class__(tiny_model, ("shared",), tmp_path / "gone.onnx").engines()
