"""What does OpenCV's YuNet find? OpenCV prepares, runs and decodes it itself.

Wu et al., *YuNet: a tiny millisecond-level face detector* (2023). Its first eye is the person's
right one, on the left of the picture: our order.
"""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch

from lrsr.errors import InputError
from lrsr.recognition.detection.contract import DetectorContract
from lrsr.recognition.detection.faces import Detection


class Yunet:
    """OpenCV's ``FaceDetectorYN`` and the contract of its weights.

    Args:
        model: The ``.onnx`` file.
        contract: What it declares.

    Raises:
        InputError: OpenCV cannot read the file.
    """

    def __init__(self, model: Path, contract: DetectorContract) -> None:
        self._model, self._iou = model, contract.nms_iou
        logged = cv2.utils.logging.getLogLevel()
        # It would warn of a target that nobody chose.
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
        try:
            self._detector: Any = cv2.FaceDetectorYN.create(str(model), "", (320, 320))
        except cv2.error as error:
            raise InputError(f"{model}: {_reason(error)}; get the file again") from error
        finally:
            cv2.utils.logging.setLogLevel(logged)

    def __call__(self, srgb: torch.Tensor, score_threshold: float) -> list[list[Detection]]:
        """Find faces on images ``(B, 3, H, W)``; the surest first.

        Raises:
            InputError: It is no YuNet.
        """
        self._detector.setInputSize((srgb.shape[-1], srgb.shape[-2]))
        self._detector.setScoreThreshold(score_threshold)
        self._detector.setNMSThreshold(self._iou)
        levels = srgb.mul(255).round().to(torch.uint8).permute(0, 2, 3, 1).numpy(force=True)
        try:
            rows = [self._detector.detect(np.ascontiguousarray(one[..., ::-1])) for one in levels]
        except cv2.error as error:
            raise InputError(f"{self._model}: {_reason(error)}; is it YuNet?") from error
        return [[] if found is None else [*map(_detection, found)] for _, found in rows]


def _detection(row: Any) -> Detection:
    """Read left, top, width, height, five points and the score."""
    left, top, width, height = row[:4]
    box = np.array([left, top, left + width, top + height], dtype=np.float32)
    return Detection(box, float(row[14]), np.asarray(row[4:14], dtype=np.float32).reshape(5, 2))


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[:160]
