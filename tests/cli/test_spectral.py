"""A camera with measured filters, as a user would type it."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

WORDS = ["render", "identities.count=1", "camera=nikon_d5100", "ipd_px=8", "out=probes"]
TINY = ["rendering.samples_per_pixel=64", "rendering.texture_size=64"]


@pytest.mark.slow  # what a spectral variant shows, tests/rendering asks of one process for all
def test_a_spectral_variant_takes_pictures_that_are_balanced_to_their_room(tmp_path: Path) -> None:
    environment = {**os.environ, "LRSR_VARIANT": "llvm_ad_spectral"}
    environment["LRSR_CACHE"] = str(tmp_path / "cache")
    words = [*WORDS, *TINY, "scales=[1,2]", "lighting=room_yellow"]
    command = [sys.executable, "-m", "lrsr", *words]
    subprocess.run(command, check=True, cwd=tmp_path, env=environment, capture_output=True)
    folder = tmp_path / "probes"
    rows = list(csv.DictReader((folder / "manifest.csv").read_text().splitlines()))
    assert [(row["camera"], row["scale"]) for row in rows] == [
        ("nikon_d5100", "1"),
        ("reference", "2"),
    ]
    probe, reference = (cv2.imread(str(folder / row["file"])) for row in rows)
    assert (probe.shape, reference.shape) == ((32, 32, 3), (64, 64, 3))
    walls = [picture[: len(picture) // 6, : len(picture) // 6] for picture in (probe, reference)]
    # Fill of (1, 0.78, 0.45), window and wall together being white: the wall is faintly yellow.
    for wall in walls:
        blue, _, red = wall.mean(axis=(0, 1))
        assert 5 < red - blue < 40
    assert np.abs(walls[0].mean(axis=(0, 1)) - walls[1].mean(axis=(0, 1))).max() < 8
