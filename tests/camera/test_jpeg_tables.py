"""Checked against what Pillow writes."""

import io
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from lrsr.camera.jpeg_tables import chrominance_table, luminance_table


@pytest.mark.parametrize("quality", [1, 10, 49, 50, 75, 95, 100])
def test_tables_are_those_that_pillow_writes(quality: int) -> None:
    file = io.BytesIO()
    Image.fromarray(np.zeros((8, 8, 3), np.uint8)).save(file, "JPEG", quality=quality)
    tables = Image.open(file).quantization
    assert luminance_table(quality).flatten().tolist() == tables[0]
    assert chrominance_table(quality).flatten().tolist() == tables[1]


def test_steps_fall_as_quality_rises() -> None:
    tables = [luminance_table(quality) for quality in range(1, 101)]
    assert all(bool((a >= b).all()) for a, b in pairwise(tables))
    assert tables[-1].max() == 1
