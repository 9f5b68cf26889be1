"""Checked against what OpenCV writes."""

import struct

import cv2
import numpy as np
import pytest

from lrsr.calibration.jpeg_files import _nearest_quality, read_jpeg_settings
from lrsr.camera.jpeg_tables import chrominance_table, luminance_table


def encoded(quality: int, factor: int = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420) -> bytes:
    rows = np.random.default_rng(5).integers(0, 256, (32, 32, 3), dtype=np.uint8)
    settings = [cv2.IMWRITE_JPEG_QUALITY, quality, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, factor]
    return bytes(cv2.imencode(".jpg", rows, settings)[1])


@pytest.mark.parametrize("quality", [1, 37, 50, 75, 100])
def test_the_file_tells_its_own_quality(quality: int) -> None:
    assert read_jpeg_settings(encoded(quality)) == (quality, "4:2:0")


@pytest.mark.parametrize(
    ("factor", "chroma"),
    [
        (cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444, "4:4:4"),
        (cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422, "4:2:2"),
    ],
)
def test_the_file_tells_its_sub_sampling(factor: int, chroma: str) -> None:
    assert read_jpeg_settings(encoded(80, factor)) == (80, chroma)


def test_a_grey_file_has_its_colour_at_full_size() -> None:
    _, file = cv2.imencode(".jpg", np.full((16, 16), 90, np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 66])
    assert read_jpeg_settings(bytes(file)) == (66, "4:4:4")


def test_a_file_cut_short_tells_nothing() -> None:
    assert read_jpeg_settings(encoded(75)[:40]) is None


def test_other_files_tell_nothing() -> None:
    assert read_jpeg_settings(bytes(cv2.imencode(".png", np.zeros((8, 8), np.uint8))[1])) is None


def test_a_foreign_table_has_a_nearest_quality() -> None:
    assert abs(_nearest_quality(1.1 * luminance_table(50)) - 50) <= 5


def exif(order: str, orientation: int) -> bytes:
    """An APP1 segment that says how a picture is to be turned."""
    tiff = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(f"{order}I", 8)
    tiff += struct.pack(f"{order}HHHIHH", 1, 0x0112, 3, 1, orientation, 0)
    return b"\xff\xe1" + struct.pack(">H", 8 + len(tiff)) + b"Exif\0\0" + tiff


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_file_that_is_to_be_turned_has_its_blocks_elsewhere(order: str) -> None:
    file = encoded(80)
    upright, turned = (file[:2] + exif(order, k) + file[2:] for k in (1, 6))
    assert read_jpeg_settings(upright) == (80, "4:2:0")
    assert read_jpeg_settings(turned) is None
    assert read_jpeg_settings(file[:2] + b"\xff\xe1\0\x0aExif\0\0MM" + file[2:]) == (80, "4:2:0")


def test_filling_bytes_before_a_marker_are_passed_over() -> None:
    file = encoded(80)
    assert read_jpeg_settings(file[:2] + b"\xff\xff" + file[2:]) == (80, "4:2:0")


def test_luminance_names_its_own_table() -> None:
    file = bytearray(encoded(90))
    start = file.index(b"\xff\xc0") + 4  # precision, sides, three of (name, factors, table)
    chroma = _nearest_quality(chrominance_table(90))
    assert file[start + 8] == 0
    file[start + 8] = 1
    assert read_jpeg_settings(bytes(file)) == (chroma, "4:2:0")


@pytest.mark.parametrize(
    ("factors", "chroma"),
    [
        ((0x22, 0x22, 0x22), "4:4:4"),
        ((0x22, 0x12, 0x12), "4:2:2"),
        ((0x22, 0x21, 0x21), None),  # 4:4:0
        ((0x22, 0x11, 0x22), None),
        ((0x22, 0x01, 0x11), None),
    ],
)
def test_sub_sampling_is_a_ratio(factors: tuple[int, ...], chroma: str | None) -> None:
    file = bytearray(encoded(90))
    start = file.index(b"\xff\xc0") + 4
    file[start + 7 : start + 15 : 3] = bytes(factors)
    assert read_jpeg_settings(bytes(file)) == (None if chroma is None else (90, chroma))
