from pathlib import Path

import pytest
from fakes.configurations import composed

from lrsr.errors import InputError
from lrsr.recognition.detection.enlargement import Enlargement
from lrsr.recognition.memory import Memory
from lrsr.recognition.settings import RecognitionSettings


def read(*words: str, command: str = "eval") -> RecognitionSettings:
    return RecognitionSettings.from_config(composed(command, *words))


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
        *(
            "recognition.recognisers=[shipped,mixed_resolution]",
            "recognition.weights=c.safetensors",
        ),
    ]
    assert read(*words) == RecognitionSettings(
        Path("a.onnx").resolve(),
        ("own",),
        Path("b.onnx").resolve(),
        Enlargement(border=0.5, shorter_px=1024),
        0.9,
        "deepface",
        "whole_image",
        ("shipped", "mixed_resolution"),
        weights=Path("c.safetensors").resolve(),
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
    finder = settings.finder(Memory(tmp_path))
    assert finder is not None
    assert (finder.detector.enlargement, finder.detector.score_threshold) == (rule, 0.7)


def test_a_missing_detector_is_refused_where_one_is_needed(tmp_path: Path) -> None:
    gone = tmp_path / "gone.onnx"
    with pytest.raises(InputError, match=r"gone\.onnx is missing"):
        RecognitionSettings(landmarks=("own",), detector=gone).finder()
    assert RecognitionSettings(landmarks=("shared",), detector=gone).finder() is None


def test_a_whole_picture_stands_for_no_face_only_where_an_onnx_file_takes_it() -> None:
    settings = RecognitionSettings(recognisers=("shipped", "lbp"), fallback="whole_image")
    with pytest.raises(InputError, match=r"recognition\.fallback=whole_image: only ONNX files"):
        settings.engines()
