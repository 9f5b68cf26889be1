"""Tests of lrsr/recognition/detection/portrait.py."""

import cv2
import numpy as np
from skimage.data import astronaut

from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.portrait import portrait_faces


def test_the_faces_of_a_large_picture_are_in_its_own_px() -> None:
    face = astronaut()[:280, 60:400]
    large = cv2.resize(face, (1020, 840), interpolation=cv2.INTER_LINEAR)
    detector = Detector()
    small, found = (portrait_faces(one, detector, 640) for one in (face, large))
    assert (
        len(found) == len(portrait_faces(np.concatenate([face, face], axis=1), detector)) - 1 == 1
    )
    where = (small[0].landmarks_px + 0.5) * 3 - 0.5
    assert np.abs(found[0].landmarks_px - where).max() < 13  # a tenth of the distance of the eyes
