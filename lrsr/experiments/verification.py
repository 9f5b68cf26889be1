"""Does this way of enlarging help to tell people apart, and under which conditions?"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tqdm import tqdm

from lrsr.experiments.design import Design
from lrsr.experiments.trial import Trial
from lrsr.experiments.verification_report import write_results
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.recognition import Engine

if TYPE_CHECKING:
    from omegaconf import DictConfig


@dataclass(frozen=True)
class Verification:
    """Compares everybody with everybody, under each condition, after each way of enlarging.

    Attributes:
        design: What is asked.
    """

    design: Design

    @classmethod
    def from_config(cls, config: "DictConfig") -> "Verification":
        """Read a composed configuration of ``lrsr eval``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        return cls(Design.from_config(config))

    def run(
        self,
        folder: Path,
        cache: RenderCache,
        *,
        maker: Maker | None = None,
        progress: bool = True,
    ) -> Path:
        """Write ``results.json``, ``report.html`` and ``faces_1.png``, ... into ``folder``.

        Args:
            folder: Of the run.
            cache: Where renderings are kept.
            maker: Renders; Mitsuba when None.
            progress: Show bars on stderr.

        Raises:
            InputError: A file or a folder is wrong; nothing has been rendered by then.
        """
        engine = Engine(self.design.model)
        trial = Trial(self.design, cache, engine, maker, progress=progress)
        trial.render()
        conditions = len(self.design.conditions)
        bar = tqdm(trial.outcomes(), "scoring", conditions, unit="condition", disable=not progress)
        return write_results(folder, self.design, engine, list(bar))
