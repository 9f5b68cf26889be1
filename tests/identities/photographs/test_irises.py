from pathlib import Path

import numpy as np
import pytest
from skimage.data import astronaut

from lrsr.errors import InputError
from lrsr.identities.face.eyes import Eyes
from lrsr.identities.photographs.irises import IrisFinder, gazes_through
from lrsr.identities.photographs.perspective import Perspective
from lrsr.paths import asset

CORNERS = {33: (194, 102), 133: (213, 103), 362: (236, 105), 263: (256, 105)}
"""Of the astronaut's eyes."""


def points(mirrored: bool = False) -> np.ndarray:
    places = np.zeros((468, 2))
    for k, place in CORNERS.items():
        places[k] = place
    if mirrored:
        places[[33, 133, 362, 263]] = places[[263, 362, 133, 33]] * [-1, 1] + [511, 0]
    return places


def test_pupils_lie_in_the_eyes_and_a_mirror_mirrors_them() -> None:
    find, picture = IrisFinder(), (astronaut() / 255).astype(np.float32)
    pupils = find(picture, points())
    np.testing.assert_allclose(pupils, [[205, 101], [247, 103]], atol=4)
    other = find(np.ascontiguousarray(picture[:, ::-1]), points(mirrored=True))
    np.testing.assert_allclose(other[::-1] * [-1, 1] + [511, 0], pupils, atol=0.1)


EYES = Eyes(
    np.array([[-31.0, 0, -12], [31, 0, -12]]), np.array([12.0, 12]), np.array([[0.0, 0, 1]] * 2)
)
SEEN = Perspective(np.eye(3), 2.0, np.array([100.0, -100]), 1e-3, np.zeros(3))


def test_eyes_turn_to_where_their_pupils_are_seen() -> None:
    gazes = np.array([[0.2, 0.1, 1.0], [0.15, 0.1, 1.0]])
    gazes /= np.linalg.norm(gazes, axis=1, keepdims=True)
    px, _ = SEEN.project(EYES._replace(gazes=gazes).pupils)
    np.testing.assert_allclose(gazes_through(EYES, SEEN, px), gazes, atol=1e-9)


@pytest.mark.parametrize("px", [(0.0, 0.0), (58.0, 100.0)], ids=["beside the eye", "on its edge"])
def test_an_eye_that_cannot_look_there_stays(px: tuple[float, float]) -> None:
    straight = SEEN.project(EYES.pupils)[0]
    found = gazes_through(EYES, SEEN, np.array([px, straight[1]]))
    np.testing.assert_allclose(found, EYES.gazes, atol=1e-9)


def test_a_contract_without_two_eyes_is_refused(tmp_path: Path) -> None:
    shipped, model = asset("landmarkers/iris_landmark.onnx"), tmp_path / "iris.onnx"
    model.write_bytes(shipped.read_bytes())
    text = shipped.with_suffix(".toml").read_text()
    model.with_suffix(".toml").write_text(text.replace(", [263, 362]]", "]"))
    with pytest.raises(InputError, match=r"crop\.corners=.*: wanted two pairs"):
        IrisFinder(model)
