"""Whose scores are these? One system: a method with its landmarks and recogniser, on some pairs."""

from array import array
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lrsr.errors import InputError
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.scores import Index, Scores, ScoreSource


@dataclass(frozen=True, order=True)
class Name:
    """What sets a system apart from others of the same files; empty where a file does not say.

    Attributes:
        option: Of the experiment.
        ipd_px: Interpupillary distance, as written.
        method: How probes were enlarged, or whose engine it is.
        landmarks: "own" or "shared".
        recogniser: What embedded them.
    """

    option: str = ""
    ipd_px: str = ""
    method: str = ""
    landmarks: str = ""
    recogniser: str = ""


@dataclass(frozen=True)
class System:
    """One system's scores.

    Attributes:
        source: The scores.
        probes: Names of the rows.
        gallery: Names of the columns; where pairs are listed, of each pair's gallery image.
        qualities: ``(rows,)`` measures of the probes, by name; NaN where one is not known.
    """

    source: ScoreSource
    probes: Sequence[str]
    gallery: Sequence[str]
    qualities: Mapping[str, Sequence[float]] = field(default_factory=dict)


class Pictures:
    """Names of pictures as numbers, and whom each shows, as far as files say.

    Attributes:
        names: In the order in which they were met.
    """

    def __init__(self) -> None:
        self.names: list[str] = []
        self._number: dict[Hashable, int] = {}
        self._person: dict[int, str] = {}

    def number(self, name: str, person: str = "", part: Hashable = "") -> int:
        """Return the number of a picture, a new one if it was not met yet.

        Args:
            name: Of the picture.
            person: Whom it shows; empty: not said.
            part: Of the files, in which equal names are equal pictures.

        Raises:
            ValueError: It was said to show somebody else.
        """
        number = self._number.setdefault((part, name), len(self.names))
        if number == len(self.names):
            self.names.append(name)
        if person and self._person.setdefault(number, person) != person:
            raise ValueError(f"{name} shows {person}, and before it {self._person[number]}")
        return number

    def people(self, mated: tuple[Index, Index]) -> list[str]:
        """Return whom each picture shows: who was named, else all that are linked by mated pairs.

        Args:
            mated: Numbers of the pictures of mated pairs.
        """
        total = len(self.names)
        links = coo_array((np.ones(mated[0].size), mated), shape=(total, total))
        _, group = connected_components(links, directed=False)
        first = np.full(total, -1)
        for number in range(total - 1, -1, -1):
            first[group[number]] = number
        return [self._person.get(k, self.names[first[group[k]]]) for k in range(total)]


class Listing:
    """Gathers the pairs of one system line by line.

    Args:
        path: Of the file, for messages.
        pictures: Shared by all systems of a run, so that equal names are equal pictures.
        qualities: Names of the measures that every line has.
    """

    def __init__(self, path: Path, pictures: Pictures, qualities: Sequence[str] = ()) -> None:
        self._path, self._pictures = path, pictures
        self._probe, self._gallery, self._line = array("q"), array("q"), array("q")
        self._score = array("d")
        self._mated = array("b")  # 1, 0, and -1 where the line does not say
        self._qualities = {name: array("d") for name in qualities}

    def add(
        self,
        line: int,
        probe: int,
        gallery: int,
        score: float,
        *,
        mated: int = -1,
        qualities: Sequence[float] = (),
    ) -> None:
        """Take one pair: numbers of two pictures, their score (NaN: failure to acquire)."""
        self._probe.append(probe)
        self._gallery.append(gallery)
        self._score.append(score)
        self._mated.append(mated)
        self._line.append(line)
        for name, value in zip(self._qualities, qualities, strict=True):
            self._qualities[name].append(value)

    def mated(self) -> tuple[Index, Index]:
        """Return the numbers of the pictures of pairs that were said to be mated."""
        probe, gallery, _, mated, _ = self._arrays()
        return probe[mated == 1], gallery[mated == 1]

    def system(self, people: Sequence[str]) -> System:
        """Return the system: a matrix where every probe meets the whole gallery, else a list.

        Args:
            people: Whom each picture shows.

        Raises:
            InputError: A pair is listed twice, or what a line says of it contradicts who it shows.
        """
        probe, gallery, score, mated, line = self._arrays()
        order = np.lexsort((line, gallery, probe))
        probe, gallery, score = probe[order], gallery[order], score[order]
        twice = np.flatnonzero((np.diff(probe) == 0) & (np.diff(gallery) == 0))
        names = self._pictures.names
        if twice.size:
            first = int(twice[np.argmin(line[order][twice + 1])])
            pair = f"{names[probe[first]]} and {names[gallery[first]]}"
            self._refuse(
                line[order][first + 1], f"{pair} were scored before; keep one of the lines"
            )
        codes = np.unique(np.array(people), return_inverse=True)[1]
        same = codes[probe] == codes[gallery]
        wrong = np.flatnonzero((mated[order] >= 0) & (same != mated[order].astype(bool)))
        if wrong.size:
            k = int(wrong[np.argmin(line[order][wrong])])
            said, found = ("mated", "two people") if not same[k] else ("non-mated", "one person")
            pair = f"{names[probe[k]]} and {names[gallery[k]]}"
            self._refuse(
                line[order][k],
                f"{pair} are said to be {said}, but other lines make them {found}; mend either",
            )
        rows, row = np.unique(probe, return_index=True)
        columns = np.unique(gallery)
        who = [people[k] for k in rows], [people[k] for k in columns]
        if score.size == rows.size * columns.size:
            source: ScoreSource = Scores(score.reshape(rows.size, columns.size), *who)
        else:
            row = np.arange(score.size)
            rows, columns = probe, gallery
            source = PairScores(score, [people[k] for k in rows], [people[k] for k in columns])
        return System(
            source,
            [names[k] for k in rows],
            [names[k] for k in columns],
            {
                name: np.array(values)[order][row].tolist()
                for name, values in self._qualities.items()
            },
        )

    def _arrays(self) -> tuple[Index, Index, np.ndarray, np.ndarray, Index]:
        return (
            np.array(self._probe, dtype=np.intp),
            np.array(self._gallery, dtype=np.intp),
            np.array(self._score),
            np.array(self._mated),
            np.array(self._line, dtype=np.intp),
        )

    def _refuse(self, line: int, why: str) -> None:
        raise InputError(f"{self._path}, line {line}: {why}")
