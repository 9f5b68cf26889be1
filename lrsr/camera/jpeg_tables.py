"""Which steps does JPEG quantise with? Of a quality, and of a file.

The tables are those of annex K of ITU-T T.81, K.1 and K.2, on the scale of the Independent JPEG
Group, as libjpeg writes them.
"""

import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

BLOCK_PX = 8
Floats = NDArray[np.float64]

# Luminance, row by row.
_ROWS = """16 11 10 16 24 40 51 61 12 12 14 19 26 58 60 55 14 13 16 24 40 57 69 56 14 17 22 29 51
87 80 62 18 22 37 56 68 109 103 77 24 35 55 64 81 104 113 92 49 64 78 87 103 121 120 101 72 92 95 98
112 100 103 99"""
_LUMINANCE = np.array(_ROWS.split(), dtype=np.int64).reshape(BLOCK_PX, BLOCK_PX)
_CHROMINANCE = np.full((BLOCK_PX, BLOCK_PX), 99)
_CHROMINANCE[:4, :4] = [[17, 18, 24, 47], [18, 21, 26, 66], [24, 26, 56, 99], [47, 66, 99, 99]]
_ORIENTATION = 0x0112  # Exif 2.32, 4.6.5
_ZIGZAG = sorted(
    range(64),
    key=lambda k: (k // 8 + k % 8, k // 8 if (k // 8 + k % 8) % 2 else k % 8),
)


def luminance_table(quality: int) -> Floats:
    """Return the steps ``(8, 8)`` (down, right) of luminance that libjpeg uses at a quality.

    Args:
        quality: 1-100.

    Example:
        >>> luminance_table(75)[0, :4].tolist()
        [8.0, 6.0, 5.0, 8.0]
    """
    return _scaled(_LUMINANCE, quality)


def chrominance_table(quality: int) -> Floats:
    """Return the steps ``(8, 8)`` of both colours' coefficients.

    Args:
        quality: 1-100.

    Example:
        >>> chrominance_table(75)[0, :5].tolist()
        [9.0, 9.0, 12.0, 24.0, 50.0]
    """
    return _scaled(_CHROMINANCE, quality)


def nearest_quality(table: Floats) -> int:
    """Return the quality whose luminance table ``(8, 8)`` is nearest, by mean log ratio.

    Example:
        >>> nearest_quality(luminance_table(40))
        40
    """
    distance = [
        float(np.abs(np.log(np.asarray(table) / luminance_table(quality))).mean())
        for quality in range(1, 101)
    ]
    return 1 + int(np.argmin(distance))


def read_jpeg_settings(file: bytes) -> tuple[int, str] | None:
    """Read quality and chroma sub-sampling from the tables of a JPEG file.

    Args:
        file: Its bytes.

    Returns:
        The quality whose luminance table is nearest to the file's, and e.g. "4:2:0" ("4:4:4" for a
        file without colour); None for another kind of file, a broken one, rare sub-sampling, or one
        that is to be shown turned, whose blocks then lie elsewhere.

    Example:
        >>> read_jpeg_settings(b"GIF89a") is None
        True
    """
    if not file.startswith(b"\xff\xd8"):
        return None
    tables: dict[int, Floats] = {}
    frame = b""
    for marker, content in _segments(file):
        if marker == 0xDB:
            tables |= _tables(content)
        elif marker in (0xC0, 0xC1, 0xC2):
            frame = content
        elif marker == 0xE1 and _turned(content):
            return None
    chroma = _chroma(frame)
    if chroma is None or frame[8] not in tables:
        return None
    return nearest_quality(tables[frame[8]]), chroma


def _segments(file: bytes) -> Sequence[tuple[int, bytes]]:
    """Return marker and content of everything before the scan."""
    found, place = [], 2
    while place + 4 <= len(file) and file[place] == 0xFF and file[place + 1] != 0xDA:
        if file[place + 1] == 0xFF:  # a filling byte
            place += 1
            continue
        length = int.from_bytes(file[place + 2 : place + 4], "big")
        found.append((file[place + 1], file[place + 4 : place + 2 + length]))
        place += 2 + length
    return found


def _tables(content: bytes) -> dict[int, Floats]:
    """Return the tables of a DQT segment by their numbers, from their zigzag order."""
    tables, place = {}, 0
    while place < len(content):
        wide, number = content[place] >> 4, content[place] & 15
        size = 128 if wide else 64
        steps = np.frombuffer(content[place + 1 : place + 1 + size], ">u2" if wide else "u1")
        if len(steps) == 64 and steps.min() > 0:
            table = np.empty(64)
            table[_ZIGZAG] = steps
            tables[number] = table.reshape(BLOCK_PX, BLOCK_PX)
        place += 1 + size
    return tables


def _chroma(frame: bytes) -> str | None:
    """Return the sub-sampling that a start-of-frame segment says."""
    if len(frame) < 9:
        return None
    if frame[5] == 1:
        return "4:4:4"
    factors = frame[7 : 6 + 3 * frame[5] : 3]
    luma, *colours = ((one >> 4, one & 15) for one in factors)
    if any(0 in one for one in colours):
        return None
    shares = {(luma[0] / across, luma[1] / down) for across, down in colours}
    kinds: dict[tuple[float, float], str] = {(1, 1): "4:4:4", (2, 1): "4:2:2", (2, 2): "4:2:0"}
    return kinds.get(shares.pop()) if len(shares) == 1 else None


def _turned(exif: bytes) -> bool:
    """Tell whether an Exif segment says that the picture is to be turned or mirrored."""
    if not exif.startswith(b"Exif\0\0"):
        return False
    tiff = exif[6:]
    order = "<" if tiff.startswith(b"II") else ">"
    try:
        (start,) = struct.unpack_from(f"{order}I", tiff, 4)
        (count,) = struct.unpack_from(f"{order}H", tiff, start)
        for k in range(count):
            tag, _, _, value = struct.unpack_from(f"{order}HHIH", tiff, start + 2 + 12 * k)
            if tag == _ORIENTATION:
                return bool(value != 1)
    except struct.error:
        return False  # cut short
    return False


def _scaled(table: NDArray[Any], quality: int) -> Floats:
    scale = 5000 // quality if quality < 50 else 200 - 2 * quality
    return np.asarray(((table * scale + 50) // 100).clip(1, 255), dtype=np.float64)
