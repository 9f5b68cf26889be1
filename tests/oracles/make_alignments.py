"""Writes tests/data/alignments_*.json with other people's aligners; not run by the tests.

In an environment with the package that is named, from the folder ``tests``::

    python -m oracles.make_alignments insightface     # 2.1: utils/face_align.py
    python -m oracles.make_alignments deepface        # 0.0.103: modules/detection.py
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

DATA = Path(__file__).parents[1] / "data"
CASES = {
    "upright": ([[14, 12], [22, 12], [18, 16], [15, 21], [21, 21]], [10, 4, 26.9, 26]),
    "turned": ([[14.2, 12.7], [22.9, 10.1], [18, 16], [15, 21], [22, 20]], [9.6, 3.2, 27.3, 27.8]),
    "turned back": ([[10, 9.4], [17.8, 12.9], [13, 16], [9, 19], [16, 21]], [5.2, 1.9, 20, 25]),
    "at the edge": ([[2.5, 6.5], [12.4, 3.4], [8, 10], [6, 15], [13, 13]], [-5.3, -6.8, 16.2, 19]),
    "beyond it": ([[30, 30], [41, 34], [35, 40], [29, 44], [38, 47]], [22.5, 20.5, 47.8, 52.1]),
    "steep": ([[12.3, 20.8], [18.1, 11.6], [20, 18], [18, 25], [23, 18]], [6, 6, 28, 29]),
}
"""Five landmarks and a box, px of :func:`picture`."""


def picture() -> np.ndarray:
    """Smooth colours and a little noise: ``(40, 36, 3)``, 8 bits."""
    y, x = np.mgrid[:40, :36]
    waves = np.stack([np.sin(x / 3), np.cos(y / 4), np.sin((x + y) / 5)], axis=-1)
    noise = np.random.default_rng(0).uniform(-20, 20, (40, 36, 3))
    return np.clip(128 + 90 * waves + noise, 0, 255).astype(np.uint8)


def insightface() -> dict[str, Any]:
    """Crops by norm_crop, every fourth pixel."""
    from insightface.utils import face_align

    crops = {}
    for name, (points, _) in CASES.items():
        landmarks = np.array(points, dtype=np.float32)
        crop = face_align.norm_crop(picture().astype(np.float32), landmarks)
        crops[name] = np.asarray(crop[4::16, 4::16]).round(4).tolist()
    return crops


def deepface() -> dict[str, Any]:
    """The face that extract_faces returns where RetinaFace says what CASES says, and at 112 px."""
    from deepface.models.face_detection.RetinaFace import RetinaFaceClient, rf
    from deepface.modules import detection, modeling
    from deepface.modules.preprocessing import resize_image

    faces = {}
    client = RetinaFaceClient.__new__(RetinaFaceClient)
    client.model = None
    modeling.build_model = lambda **_: client
    order = ("right_eye", "left_eye", "nose", "mouth_right", "mouth_left")
    for name, (points, box) in CASES.items():
        border = np.array([36 // 2, 40 // 2])
        found = {
            "score": 1.0,
            "facial_area": list((np.array(box) + np.tile(border, 2)).astype(int)),
            "landmarks": {
                k: list(np.array(p) + border) for k, p in zip(order, points, strict=True)
            },
        }
        rf.detect_faces = lambda *_, found=found, **__: {"face_1": found}
        (face,) = detection.extract_faces(
            picture()[..., ::-1], detector_backend="retinaface", normalize_face=False
        )
        levels = np.asarray(face["face"])
        square = resize_image(levels[..., ::-1], (112, 112))[0, ..., ::-1]
        faces[name] = {
            "face": levels.tolist(),
            "square": (square[4::16, 4::16] * 255).round(3).tolist(),
        }
    return faces


if __name__ == "__main__":
    name = sys.argv[1]
    path = DATA / f"alignments_{name}.json"
    lines = (__doc__ or "").splitlines()
    source = next(line.strip() for line in lines if f"alignments {name}" in line)
    path.write_text(json.dumps({"source": source, **globals()[name]()}) + "\n")
