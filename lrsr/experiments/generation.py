"""What does ``lrsr generate`` do? It photographs people whom a network makes up.

After Colbois, de Freitas Pereira and Marcel (IJCB 2021): planes in the latent space tell how faces
are held, lit and moved (:mod:`lrsr.identities.generated.boundaries`); everybody drawn is made
neutral by them and taken if the filters pass and nobody taken before is alike.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self

from lrsr.configuration import (
    as_list,
    as_mapping,
    as_number,
    as_word,
    number,
    require,
    section,
    seed_of,
    whole_number,
)
from lrsr.errors import InputError
from lrsr.experiments.generated_people import GeneratedPeople
from lrsr.experiments.learned_directions import Learning
from lrsr.identities.generated.boundaries import Boundaries, read_boundaries, write_boundaries
from lrsr.identities.generated.generator import Generator
from lrsr.identities.photographs.quality import Filters
from lrsr.onnx import DEVICES
from lrsr.paths import path_if_any, user_path
from lrsr.recognition.recognisers import SMALLEST_ANGLE_DEG, load_encoder, resolve_encoder

if TYPE_CHECKING:
    from omegaconf import DictConfig

_BOUNDARIES = "boundaries.safetensors"

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Generating:
    """Whom to make, and how.

    Attributes:
        generator: ONNX file with its contract beside it.
        count: People.
        seed: Of all that is drawn.
        truncation: Psi; see :meth:`lrsr.identities.generated.generator.Generator.sample`.
        boundaries: Those of an earlier run; None: they are learned.
        learning: How.
        attributes: The neutral value of each; None: the median one.
        variations: Increments of some attributes.
        encoder: Says who is alike.
        smallest_angle_deg: Who is nearer to somebody before is refused.
        model: ONNX embedder in place of the shipped one.
        most_refused: One after another, then it gives up.
        device: See :func:`lrsr.onnx.providers_on`.
        filters: Who is refused.

    Raises:
        InputError: A value is out of its range.
    """

    generator: Path
    count: int
    seed: int
    truncation: float
    boundaries: Path | None
    learning: Learning
    attributes: Mapping[str, float | None]
    variations: Mapping[str, tuple[float, ...]]
    encoder: Literal["dlib", "shipped"]
    smallest_angle_deg: float
    model: Path | None = None
    most_refused: int = 100
    device: str = "auto"
    filters: Filters = field(default_factory=Filters)

    def __post_init__(self) -> None:
        angle = self.smallest_angle_deg
        require(self.count >= 0, "count", self.count, "at least 0")
        require(0 <= self.truncation <= 1, "truncation", self.truncation, "0 to 1")
        require(0 <= angle < 90, "smallest_angle_deg", angle, "0 to 90 degrees")
        require(self.most_refused >= 1, "most_refused", self.most_refused, "at least 1")
        require(self.device in DEVICES, "device", self.device, f"one of {', '.join(DEVICES)}")
        require(bool(self.attributes), "attributes", "{}", "at least one")
        for name in self.attributes:  # files are called by them
            require(name.isidentifier(), "attributes", name, "letters, digits and _")

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr generate``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        encoder = resolve_encoder(str(config.encoder))
        usual = config.smallest_angle_deg is None
        least = SMALLEST_ANGLE_DEG[encoder] if usual else number(config, "smallest_angle_deg")
        neutral = as_mapping(config.attributes, "attributes")
        varied = as_mapping(config.variations, "variations")
        return cls(
            generator=user_path(config.generator, "generator"),
            count=whole_number(config, "count"),
            seed=seed_of(config),
            truncation=number(config, "truncation"),
            boundaries=path_if_any(config.boundaries, "boundaries"),
            learning=section(Learning, config, "learning"),
            attributes={
                str(name): None if value is None else as_number(value, f"attributes.{name}")
                for name, value in neutral.items()
            },
            variations={
                str(name): tuple(
                    as_number(one, f"variations.{name}")
                    for one in as_list(given, f"variations.{name}")
                )
                for name, given in varied.items()
            },
            encoder=encoder,
            smallest_angle_deg=least,
            model=path_if_any(config.recognition.model, "recognition.model"),
            most_refused=whole_number(config, "most_refused"),
            device=as_word(config.device, "device"),
            filters=section(Filters, config, "filters"),
        )

    def run(self, folder: Path, *, progress: bool = True) -> Path:
        """Make who is missing; write the boundaries, pictures, the record and a sheet.

        Stopped at any moment, the same call goes on; with a larger count it goes on, too.

        Args:
            folder: Where they go.
            progress: Show bars.

        Raises:
            InputError: The generator or the boundaries cannot be used, the folder holds people of
                other settings, or too many in a row are refused; whoever was taken is there.
        """
        generator = Generator(self.generator, device=self.device)
        boundaries = self._boundaries(generator, folder, progress=progress)
        if not self.count:
            return folder
        people = GeneratedPeople(
            folder=folder,
            generator=generator,
            boundaries=boundaries,
            encoder=load_encoder(self.encoder, self.model, device=self.device),
            seed=self.seed,
            truncation=self.truncation,
            variations=self.variations,
            smallest_angle_deg=self.smallest_angle_deg,
            filters=self.filters,
        )
        people.find(self.count, self.most_refused, progress=progress)
        people.write()
        refused = "".join(f", {which} {n}" for which, n in people.refusals().items())
        taken, drawn = len(people.taken), len(people.looked)
        logger.info("%d drawn: %d taken, %d refused%s", drawn, taken, drawn - taken, refused)
        if taken < self.count:
            raise InputError(
                f"count={self.count}: {taken} people are there, the last {people.refused_in_a_row}"
                f" drawn were refused ({refused[2:]}); widen the filters, lower smallest_angle_deg,"
                " raise truncation, or raise most_refused"
            )
        return folder

    def _boundaries(self, generator: Generator, folder: Path, *, progress: bool) -> Boundaries:
        """Read the boundaries, or learn them.

        Raises:
            InputError: They cannot be had.
        """
        if self.boundaries is not None:
            return read_boundaries(self.boundaries, generator.size)
        drawn = {"seed": self.seed, "truncation": self.truncation}
        learned = self.learning.learn(generator, self.attributes, drawn, folder, progress=progress)
        write_boundaries(folder / _BOUNDARIES, learned)
        for name, told in learned.record["attributes"].items():
            logger.info(
                "%s: %.0f %% of held-out faces on the right side, correlation %.2f",
                name, 100 * told["held_out_right"], told["correlation"],
            )  # fmt: skip
        return learned
