"""Where are the faces on pictures of any size? Enlarge, find, and come back to the picture."""

from pathlib import Path

import torch

from lrsr.configuration import require
from lrsr.images import check_srgb
from lrsr.paths import asset
from lrsr.recognition.detection.contract import read_detector_contract
from lrsr.recognition.detection.enlargement import Enlargement
from lrsr.recognition.detection.faces import Detection
from lrsr.recognition.detection.network import Network
from lrsr.recognition.detection.yunet import Yunet

_DEFAULT_MODEL = "detectors/retinaface_mnet025.onnx"
"""Trained on photographs (WIDER FACE) by others; licence and origin lie beside it."""


class Detector:
    """A face detector and how pictures are prepared for it.

    Args:
        model: An ONNX detector with its contract beside it; default: the one that ships.
        enlargement: How small pictures are enlarged.
        score_threshold: Least score of a face, [0, 1]; None: the contract's.
        device: Where the network runs, "cpu" or "cuda".

    Raises:
        InputError: The contract is missing, broken or about another file; the file is no such
            detector; or the threshold is out of range.
    """

    def __init__(
        self,
        model: Path | None = None,
        *,
        enlargement: Enlargement | None = None,
        score_threshold: float | None = None,
        device: str = "cpu",
    ) -> None:
        self.model = Path(model or asset(_DEFAULT_MODEL))  # a notebook may give a word
        self.contract = read_detector_contract(self.model)
        self.enlargement = enlargement or Enlargement()
        threshold = self.contract.score_threshold if score_threshold is None else score_threshold
        require(0 <= threshold <= 1, "recognition.score_threshold", threshold, "0 to 1")
        self.score_threshold = threshold
        self._find: Yunet | Network = (
            Yunet(self.model, self.contract)
            if self.contract.kind == "yunet"
            else Network(self.model, self.contract, device=device)
        )

    def __call__(self, srgb: torch.Tensor, *, ipd_px: float | None = None) -> list[list[Detection]]:
        """Find all faces on each picture.

        Args:
            srgb: ``(B, 3, H, W)`` float32, srgb, [0, 1].
            ipd_px: Distance between the pupils of faces on them, where that is known; see
                :class:`lrsr.recognition.detection.enlargement.Enlargement`.

        Returns:
            For each picture its faces, the surest first; none is no error.

        Raises:
            ImageContractError: The pictures break the contract of :mod:`lrsr.images`.
            InputError: The network cannot take them.
        """
        rule, multiple_px = self.enlargement, self.contract.multiple_px
        large, back = rule(check_srgb(srgb), multiple_px=multiple_px, ipd_px=ipd_px)
        return [
            [
                Detection(
                    back(face.box_px.reshape(2, 2)).ravel(), face.score, back(face.landmarks_px)
                )
                for face in faces
            ]
            for faces in self._find(large, self.score_threshold)
        ]

    def describe(self) -> dict[str, object]:
        """Return what a report must say of the detector; JSON-serialisable."""
        return {
            "model": self.model.name,
            "sha256": self.contract.sha256,
            "licence": self.contract.licence,
            "source": self.contract.source,
            "kind": self.contract.kind,
            "score_threshold": self.score_threshold,
            "nms_iou": self.contract.nms_iou,
            "enlargement": vars(self.enlargement),
        }
