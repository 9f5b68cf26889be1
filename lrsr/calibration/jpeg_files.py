"""How was a JPEG file squeezed? Its own tables and factors say it."""

import io
from contextlib import suppress
from warnings import catch_warnings

import numpy as np
from PIL import ExifTags, Image
from PIL.JpegImagePlugin import JpegImageFile

from lrsr.camera.jpeg_tables import BLOCK_PX, Floats, luminance_table

_CHROMAS: dict[tuple[float, float], str] = {(1, 1): "4:4:4", (2, 1): "4:2:2", (2, 2): "4:2:0"}


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
    content = io.BytesIO(file)
    try:
        # Pillow warns of broken Exif.
        with catch_warnings(action="ignore"), Image.open(content, formats=["JPEG"]) as picture:
            if not isinstance(picture, JpegImageFile) or _turned(picture):
                return None
            (_, across, down, table), *colours = picture.layer
            steps = np.array(picture.quantization[table], dtype=np.float64)
            shares = {(across / one[1], down / one[2]) for one in colours} or {(1.0, 1.0)}
    except (OSError, KeyError, ValueError, ArithmeticError):  # unidentified is an OSError too
        return None
    chroma = _CHROMAS.get(shares.pop()) if len(shares) == 1 else None
    if chroma is None or steps.min() <= 0:
        return None
    return _nearest_quality(steps.reshape(BLOCK_PX, BLOCK_PX)), chroma


def _nearest_quality(table: Floats) -> int:
    """Return the quality whose luminance table ``(8, 8)`` is nearest, by mean log ratio.

    Example:
        >>> _nearest_quality(luminance_table(40))
        40
    """
    distance = [
        float(np.abs(np.log(np.asarray(table) / luminance_table(quality))).mean())
        for quality in range(1, 101)
    ]
    return 1 + int(np.argmin(distance))


def _turned(picture: JpegImageFile) -> bool:
    """Tell whether a file says that it is to be turned or mirrored; broken Exif says nothing."""
    with suppress(SyntaxError, OSError, ValueError):
        return bool(picture.getexif().get(ExifTags.Base.Orientation, 1) != 1)
    return False
