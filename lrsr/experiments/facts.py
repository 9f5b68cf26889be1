"""What is known of a case? Its camera's pictures, its score or its two files, scores of others."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from lrsr.configuration import as_number, as_whole, require
from lrsr.experiments.pair import Pair
from lrsr.paths import path_if_any

if TYPE_CHECKING:
    from omegaconf import DictConfig

_FILES = ("images", "probe", "enrolled", "scores", "generic_scores", "real_scores")


@dataclass(frozen=True)
class Facts:
    """What is known of a case.

    Attributes:
        images: Folder of pictures by its camera; None: the camera is known.
        part: Share of their sides that counts, as of ``lrsr fit-camera``.
        rounds: Of the search for the camera.
        score: Of its two pictures; None: not known, or not asked.
        pair: Its two pictures, likewise.
        scores: Of an engine of somebody's on simulated people; None: ours compares them.
        generic_scores: The same engine's scores of other pictures.
        real_scores: Scores of real people.

    Raises:
        InputError: Facts exclude each other.
    """

    images: Path | None = None
    part: float = 0.75
    rounds: int = 12
    score: float | None = None
    pair: Pair | None = None
    scores: Path | None = None
    generic_scores: Path | None = None
    real_scores: Path | None = None

    def __post_init__(self) -> None:
        if self.score is not None:
            require(self.pair is None, "case.score", self.score, "null where case.probe is given")
        if self.scores is None:
            wish = "case.scores besides: both are of one engine"
            given = self.generic_scores
            require(given is None, "case.generic_scores", given, wish)
            return
        for name in ("images", "pair"):
            wish = "null where case.scores is given: give case.score"
            require(getattr(self, name) is None, f"case.{name}", "...", wish)


def read_facts(config: "DictConfig") -> Facts:
    """Read the section ``case``.

    Raises:
        InputError: A value is wrong.
    """
    given = config.case
    files = {key: path_if_any(given[key], f"case.{key}") for key in _FILES}
    both = [key for key in ("probe", "enrolled") if files[key] is not None]
    wish = "both case.probe and case.enrolled, or neither"
    require(len(both) != 1, f"case.{both[0] if both else ''}", "...", wish)
    probe, enrolled = files.pop("probe"), files.pop("enrolled")
    return Facts(
        **files,
        part=as_number(given.part, "case.part"),
        rounds=as_whole(given.rounds, "case.rounds"),
        score=None if given.score is None else as_number(given.score, "case.score"),
        pair=None if probe is None or enrolled is None else Pair(probe, enrolled),
    )
