"""Tests of lrsr/experiments/report/sentences.py."""

from pathlib import Path

import pytest

from lrsr.experiments.report.sentences import about_recognition
from lrsr.recognition.settings import Landmarks, RecognitionSettings


@pytest.mark.parametrize(
    ("landmarks", "begins", "detector"),
    [
        (["shared"], ["Shared landmarks"], False),
        (["own"], ["Own landmarks"], True),
        (["shared", "own"], ["Shared landmarks", "Own landmarks"], True),
    ],
    ids=["shared", "own", "both"],
)
def test_sources_of_landmarks_are_told(
    landmarks: list[Landmarks], begins: list[str], detector: bool
) -> None:
    done, not_done = about_recognition(RecognitionSettings(), landmarks)
    assert [sentence.partition(":")[0] for sentence in done] == begins
    assert any("No face detector" in sentence for sentence in not_done) is not detector


def test_only_the_shipped_embedder_needs_a_warning() -> None:
    for settings, warned in (
        (RecognitionSettings(), True),
        (RecognitionSettings(recognisers=("dlib",)), False),
        (RecognitionSettings(model=Path("mine.onnx")), False),
    ):
        told = " ".join(about_recognition(settings, ["own"])[1])
        assert ("has learned from faces of this renderer" in told) is warned


def test_a_whole_picture_in_place_of_a_face_is_told() -> None:
    done, _ = about_recognition(RecognitionSettings(fallback="whole_image"), ["own"])
    assert "the whole picture stood for it" in done[1]
