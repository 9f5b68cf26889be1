"""To which groups does somebody belong? By sex, age, ancestry and skin tone, where known."""

import itertools
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from lrsr.errors import InputError
from lrsr.experiments.report.demographics import DECADES, main_ancestry
from lrsr.identities.person import Traits
from lrsr.pictures.folder import Entry
from lrsr.tables import read_rows

Labels = Mapping[str, str]
"""The group of one person for each trait, e.g. ``{"sex": "female", "age": "30 to 39"}``."""

_NEEDED = "identity_id"
_COLUMNS = ("sex", "age_years", "ancestry", "skin_tone")


def labels_of(traits: Traits) -> Labels:
    """Return the groups of somebody whose traits were drawn.

    Example:
        >>> labels_of(Traits("female", 34, {"asian": 0.9, "african": 0.1}, 45, "light"))
        {'sex': 'female', 'age': '30 to 39', 'ancestry': 'asian', 'skin tone': 'light'}
    """
    return _labels(traits.sex, traits.age_years, traits.ancestry, traits.skin_tone)


def labels_of_entry(entry: Entry) -> Labels:
    """Return the groups that a manifest tells of; none where an age is no number."""
    try:
        return _read({name: getattr(entry, name) for name in _COLUMNS})
    except ValueError:
        return {}


def read_labels(path: Path) -> dict[str, Labels]:
    """Read who belongs to which group from a manifest, or any CSV with some of its columns.

    Args:
        path: Of a CSV with the column ``identity_id`` and any of ``sex``, ``age_years``,
            ``ancestry`` (as of a manifest, or a word) and ``skin_tone``.

    Raises:
        InputError: It cannot be read, has no such column, or a value does not fit.
    """
    found: dict[str, Labels] = {}
    for line, cells in read_rows(path, (_NEEDED,), "give a CSV of people"):
        if not {*_COLUMNS} & {*cells}:
            raise InputError(f"{path}, line 1: wanted some of the columns {', '.join(_COLUMNS)}")
        told = {name: cells.get(name, "").strip() for name in (_NEEDED, *_COLUMNS)}
        try:
            found[told[_NEEDED]] = _read(told)
        except ValueError as error:
            raise InputError(f"{path}, line {line}: {error}; mend it") from error
    return found


def _read(cells: Mapping[str, str]) -> Labels:
    """Return the groups that a line tells.

    Raises:
        ValueError: An age is no number.
    """
    age, ancestry = cells["age_years"], cells["ancestry"]
    shares = {ancestry: 1.0} if ancestry and "=" not in ancestry else {}
    with suppress(ValueError):
        parts = [part.split("=") for part in ancestry.split() if "=" in part]
        shares |= {race: float(share) for race, share in parts}
    try:
        years = float(age) if age else None
    except ValueError:
        raise ValueError(f"age_years={age}: wanted a number") from None
    return _labels(cells["sex"], years, shares, cells["skin_tone"])


def _labels(sex: str, years: float | None, shares: Mapping[str, float], tone: str) -> Labels:
    spans = itertools.pairwise(DECADES) if years is not None else ()
    told = {
        "sex": sex,
        "age": next((f"{a} to {b - 1}" for a, b in spans if a <= (years or 0) < b), ""),
        "ancestry": main_ancestry(shares) if shares else "",
        "skin tone": tone,
    }
    return {trait: group for trait, group in told.items() if group}
