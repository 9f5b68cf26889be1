"""How sure is every number to be told? What all experiments that have scores share."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

from lrsr.configuration import as_word, number, require, seed_of, whole_number
from lrsr.evaluation.calibrators import CALIBRATORS

if TYPE_CHECKING:
    from omegaconf import DictConfig


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

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read what any command that has scores is told.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        return cls(
            number(config, "level"),
            whole_number(config, "bootstrap"),
            seed_of(config),
            as_word(config.calibration, "calibration"),
        )
