"""How sure is every number to be told? What all experiments that have scores share."""

from dataclasses import dataclass

from lrsr.configuration import require
from lrsr.evaluation.calibrators import CALIBRATORS


@dataclass(frozen=True)
class Asked:
    """How further results are found.

    Attributes:
        level: Of every interval.
        bootstrap: Draws of people; 0: none.
        seed: Of draws and of the split of people.
        calibration: Of the likelihood ratios, one of
            :data:`lrsr.evaluation.calibrators.CALIBRATORS`.

    Raises:
        InputError: A value is out of range.
    """

    level: float
    bootstrap: int
    seed: int
    calibration: str

    def __post_init__(self) -> None:
        require(0 < self.level < 1, "level", self.level, "between 0 and 1")
        require(self.bootstrap >= 0, "bootstrap", self.bootstrap, "0 or more draws")
        known = f"one of {', '.join(CALIBRATORS)}"
        require(self.calibration in CALIBRATORS, "calibration", self.calibration, known)
