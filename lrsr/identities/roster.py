"""Who takes part, after look-alikes were redrawn? A file that says how often each one was redrawn.

``lrsr identities`` writes a roster; ``identities.roster=FILE`` makes any command use it, so that an
experiment runs on people who were checked to be different from one another.
"""

import hashlib
import json
import logging
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, cast

from lrsr.configuration import as_list, as_whole, require
from lrsr.errors import InputError
from lrsr.files import read_bytes, write_json
from lrsr.identities.person import Person
from lrsr.identities.photographs.person import HALVES, Photographed, Somebody, read_photographed
from lrsr.identities.population import (
    ANCESTRIES,
    EVERYBODY,
    OLDEST_YEARS,
    YOUNGEST_YEARS,
    Population,
    population_from,
)
from lrsr.identities.splits import LARGEST_INDEX, SPLITS, Split

_FORMAT = 1

logger = logging.getLogger(__name__)

_GALLERIES = ("render", "photograph", "other_photograph")
_PARTS = ("all", *HALVES)

_MOST_PEOPLE = 10**6
"""Of one command."""


@dataclass(frozen=True)
class Roster:
    """People ``start`` to ``start + count - 1`` of a split, and who of them was redrawn.

    Attributes:
        split: Whose people.
        start: Number of the first one.
        count: How many, >= 1.
        population: From whom they were drawn.
        recipe: Version of the recipe of heads that was checked.
        encoder: What compared them.
        angle_deg: No two of them are nearer, but for ``unresolved``.
        draws: How often each was redrawn, by index; who is not named was not.
        unresolved: Who was still too near to somebody when the bound on redraws was reached.

    Raises:
        InputError: A draw or an index is out of range, or there is no such split.
    """

    split: Split
    start: int
    count: int
    population: Population
    recipe: str
    encoder: str
    angle_deg: float
    draws: Mapping[int, int] = field(default_factory=dict)
    unresolved: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        inside = range(self.start, self.start + self.count)
        if self.split not in SPLITS or self.start < 0 or self.count < 1:
            raise InputError(
                f"a roster of the split {self.split!r} from {self.start} on, {self.count} people"
            )
        if any(index not in inside or draw < 0 for index, draw in self.draws.items()):
            raise InputError(f"a roster of {inside} redraws {dict(self.draws)}")


@dataclass(frozen=True)
class Cast:
    """From whom people are drawn, and who of them was redrawn; the default is everybody, nobody.

    Attributes:
        population: From whom.
        roster: Redraws of people of its own split; None: nobody was.

    Raises:
        InputError: The roster is of another population.
    """

    population: Population = EVERYBODY
    roster: Roster | None = None

    def __post_init__(self) -> None:
        if self.roster is not None and self.roster.population != self.population:
            sex, ancestry, (low, high) = asdict(self.roster.population).values()
            raise InputError(
                f"identities.roster is of another population: add identities.sex={sex}"
                f" identities.ancestry=[{','.join(ancestry)}]"
                f" identities.age_years=[{low:g},{high:g}]"
            )

    def draw(self, split: str, index: int) -> int:
        """Return how often somebody was redrawn.

        Args:
            split: Of the person; people of other splits than the roster's were not checked.
            index: Number within the split.

        Raises:
            InputError: The roster is of that split but does not reach to that person.
        """
        roster = self.roster
        if roster is None or roster.split != split:
            return 0
        if not roster.start <= index < roster.start + roster.count:
            last = roster.start + roster.count - 1
            raise InputError(
                f"identities.roster covers {split} {roster.start} to {last}, not {index}: take"
                " fewer people or make a longer roster with lrsr identities"
            )
        return roster.draws.get(index, 0)

    def person(self, split: Split, index: int) -> Person:
        """Return somebody, as often redrawn as the roster says.

        Raises:
            InputError: The roster is of that split but does not reach to that person.
        """
        return Person(split, index, self.draw(split, index), self.population)


@dataclass(frozen=True, kw_only=True)
class IdentityRange:
    """Who takes part, as plain values: ``count`` people of a split, from number ``start`` on.

    Attributes:
        split: "train", "validation" or "test"; nobody is in two of them.
        start: Number of the first one.
        count: How many.
        sex: See :class:`~lrsr.identities.population.Population`, as the next two.
        ancestry: Some of african, asian, caucasian.
        age_years: Youngest and oldest.
        roster: Path of a roster; None: nobody was redrawn.
        photographs: Folder of ``lrsr reconstruct``: the people on its photographs take part, from
            number ``start`` on and at most ``count``, whatever the split; None: people are drawn.
        part: Of them "all", or one half, "development" or "test", by the hash of their names.
        gallery: How they are enrolled in an experiment: "render", the "photograph" itself, or by
            an "other_photograph" of the same person; then those take part who have one.

    Raises:
        InputError: A number is out of its range, there is no such split or population, or the
            roster cannot be used or does not reach that far.
    """

    split: str = "test"
    start: int = 0
    count: int = 100
    sex: str = "any"
    ancestry: tuple[str, ...] = ANCESTRIES
    age_years: tuple[float, float] = (YOUNGEST_YEARS, OLDEST_YEARS)
    roster: str | None = None
    photographs: str | None = None
    part: str = "all"
    gallery: str = "render"

    def __post_init__(self) -> None:
        for name in ("ancestry", "age_years"):  # a configuration hands out lists
            given = as_list(getattr(self, name), f"identities.{name}")
            object.__setattr__(self, name, tuple(given))
        for name in ("start", "count"):
            whole = as_whole(getattr(self, name), f"identities.{name}")
            object.__setattr__(self, name, whole)
        require(self.split in SPLITS, "identities.split", self.split, f"one of {', '.join(SPLITS)}")
        last = LARGEST_INDEX - self.count + 1
        require(self.count >= 1, "identities.count", self.count, "at least 1")
        require(
            self.count <= _MOST_PEOPLE, "identities.count", self.count, f"at most {_MOST_PEOPLE}"
        )
        require(0 <= self.start <= last, "identities.start", self.start, f"0 to {last}")
        known = f"one of {', '.join(_GALLERIES)}"
        require(self.gallery in _GALLERIES, "identities.gallery", self.gallery, known)
        require(self.part in _PARTS, "identities.part", self.part, f"one of {', '.join(_PARTS)}")
        if self.photographs is not None:
            self._check_photographs()
            return
        wish = "render, or identities.photographs=FOLDER beside it"
        require(self.gallery == "render", "identities.gallery", self.gallery, wish)
        wish = "all: identities.split parts drawn people"
        require(self.part == "all", "identities.part", self.part, wish)
        roster = self.cast.roster
        if roster is not None:
            wanted = f"{roster.split}, as the roster's"
            require(roster.split == self.split, "identities.split", self.split, wanted)
        for index in (self.start, self.start + self.count - 1):
            self.person(index)  # refuses who is not on the roster

    def _check_photographs(self) -> None:
        """Refuse what cannot be chosen of photographs, and count who is there.

        Raises:
            InputError: The folder is none of ours or holds too few people, or they are to be others
                than they are.
        """
        wish = "no such choice: people on photographs are who they are"
        require(self.roster is None, "identities.roster", self.roster, wish)
        chosen = population_from(asdict(self)) != EVERYBODY
        require(not chosen, "identities.sex, ancestry or age_years", "", wish)
        there = len(self._photographed)
        require(self.start < there, "identities.start", self.start, f"0 to {there - 1}")
        object.__setattr__(self, "count", min(self.count, there - self.start))

    @cached_property
    def _photographed(self) -> tuple[Photographed, ...]:
        """Who of the folder can take part.

        Raises:
            InputError: The folder is none of ours, or nobody can.
        """
        found = read_photographed(Path(str(self.photographs)).expanduser().resolve())
        there = tuple(one for one in found if self.part in ("all", one.half))
        require(bool(there), "identities.part", self.part, f"all: of {len(found)} nobody is in it")
        if self.gallery != "other_photograph":
            return there
        chosen = tuple(one for one in there if one.others)
        wish = f"render or photograph: of {len(there)} people nobody has another one"
        require(bool(chosen), "identities.gallery", self.gallery, wish)
        if len(chosen) < len(there):
            logger.warning("%d of %d people have another photograph", len(chosen), len(there))
        return chosen

    @property
    def enrolled(self) -> list[Photographed] | None:
        """The photographs that people are enrolled by, in order; None: they are rendered."""
        if self.gallery == "render":
            return None
        people = self._photographed[self.start : self.start + self.count]
        return [one.others[0] if self.gallery == "other_photograph" else one for one in people]

    @cached_property
    def cast(self) -> Cast:
        """From whom they are drawn, and who of them was redrawn."""
        population = population_from(asdict(self))
        if self.roster is None:
            return Cast(population)
        return Cast(population, _read_roster(Path(self.roster).expanduser()))

    def person(self, index: int) -> Somebody:
        """Return somebody by the number within the split, or the folder of photographs."""
        if self.photographs is not None:
            return self._photographed[index]
        return self.cast.person(cast("Split", self.split), index)

    def people(self) -> list[Somebody]:
        """Return everyone, in order."""
        return [self.person(index) for index in range(self.start, self.start + self.count)]


def write_roster(path: Path, roster: Roster) -> Path:
    """Write a roster with the SHA-256 of its content; return ``path``.

    Raises:
        InputError: The file cannot be written.
    """
    content = _plain(roster)
    write_json(path, {**content, "sha256": _digest(content)})
    return path


def _read_roster(path: Path) -> Roster:
    """Read and check a roster.

    Raises:
        InputError: The file cannot be read, is no roster, was changed by hand, or was made with
            another recipe of heads; the message names the file and the remedy.
    """
    try:
        content = json.loads(read_bytes(path))  # of any Unicode, with a mark or without
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or "no JSON"
        raise InputError(f"cannot read {path}: {reason}; lrsr identities makes one") from error
    if not isinstance(content, dict) or "sha256" not in content:
        raise InputError(f"{path} is no roster; lrsr identities makes one")
    if content.pop("sha256") != _digest(content):
        raise InputError(f"{path}: its checksum does not match; make it again: lrsr identities")
    try:
        roster = _roster(content)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path} is no roster of this version; make it again") from error
    from lrsr.identities.morphable import RECIPE_VERSION  # the recipe takes a while to import

    if roster.recipe != RECIPE_VERSION:
        raise InputError(
            f"{path} is of heads of recipe {roster.recipe}, these are of {RECIPE_VERSION}: make it"
            " again with lrsr identities"
        )
    return roster


def _roster(content: Mapping[str, Any]) -> Roster:
    draws = {int(index): int(draw) for index, draw in content["draws"].items()}
    return Roster(
        split=content["split"],
        start=int(content["start"]),
        count=int(content["count"]),
        population=population_from(content["population"]),
        recipe=content["recipe"],
        encoder=content["encoder"],
        angle_deg=float(content["angle_deg"]),
        draws=draws,
        unresolved=tuple(int(index) for index in content["unresolved"]),
    )


def _plain(roster: Roster) -> dict[str, Any]:
    values = asdict(roster)
    values["draws"] = {str(index): draw for index, draw in sorted(roster.draws.items())}
    plain: dict[str, Any] = json.loads(json.dumps({"format": _FORMAT, **values}))
    return plain


def _digest(content: Mapping[str, Any]) -> str:
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
