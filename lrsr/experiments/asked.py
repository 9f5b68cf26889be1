"""How sure is every number to be told? What all experiments that have scores share."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Asked:
    """How further results are found.

    Attributes:
        level: Of every interval.
        bootstrap: Draws of people; 0: none.
        seed: Of draws and of the split of people.
        calibration: Of the likelihood ratios.
    """

    level: float
    bootstrap: int
    seed: int
    calibration: str
