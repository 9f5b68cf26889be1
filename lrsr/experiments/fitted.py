"""Which camera took a case's pictures? Fitted once; a run that goes on does not fit it again."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lrsr.calibration.from_pictures import FitSettings, fit_to_folder
from lrsr.camera.preset_file import read_preset_file
from lrsr.files import make_folder, write_text
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.image_files import SUFFIXES, read_file
from lrsr.pictures.maker import Maker

_FITTED_FROM = "fitted_from.json"


def fit_once(
    settings: FitSettings,
    folder: Path,
    cache: RenderCache,
    maker: Maker | None = None,
    *,
    progress: bool = True,
) -> Mapping[str, Any]:
    """Return the plain settings of a camera that takes pictures like a folder's.

    Args:
        settings: What is asked.
        folder: Holds the fit, with its report; one of the same pictures and settings is used again.
        cache: Where renderings are kept.
        maker: Renders the strangers; Mitsuba when None.
        progress: Show bars.

    Raises:
        InputError: See :func:`lrsr.calibration.from_pictures.fit_to_folder`.
    """
    preset, record = folder / f"{settings.name}.yaml", folder / _FITTED_FROM
    images = sorted(one for one in settings.images.glob("*") if one.suffix.lower() in SUFFIXES)
    seen = {one.name: hashlib.sha256(read_file(one)).hexdigest() for one in images}
    plain = {**vars(settings), "images": seen, "strangers": settings.strangers.describe()}
    asked = json.dumps(plain, sort_keys=True)
    if not (preset.is_file() and record.is_file() and record.read_text() == asked):
        record.unlink(missing_ok=True)
        fit_to_folder(settings, make_folder(folder), cache=cache, maker=maker, progress=progress)
        write_text(record, asked)
    return read_preset_file(preset)
