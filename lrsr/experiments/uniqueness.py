"""Is everybody in a set of people somebody else?

Everyone's gallery picture is embedded, look-alikes are redrawn until there are none, and what is
left is described: who they are, the angles between them, and the nearest pairs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from lrsr.camera import Camera
from lrsr.configuration import number, require, whole_number
from lrsr.evaluation.distinctness import (
    Distinct,
    Drawn,
    Pair,
    closest_pairs,
    draw_distinct,
    pairwise_angles_deg,
    summarise,
)
from lrsr.identities.person import Person, Traits
from lrsr.identities.roster import Roster
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.pictures.picture import stack
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.sitting import Sitting, read_gallery
from lrsr.pictures.source import Rendered, chunks, render_sources
from lrsr.presets import build
from lrsr.recognition.recognisers import SMALLEST_ANGLE_DEG, Recogniser, resolve_encoder
from lrsr.recognition.settings import RecognitionSettings

if TYPE_CHECKING:
    from omegaconf import DictConfig

_NEAREST = 10
"""Pairs that are shown side by side."""


@dataclass(frozen=True)
class UniquenessSettings:
    """Everything that the outcome depends on.

    Attributes:
        gallery: Who is looked at, and the picture of each; a roster is gone on from.
        encoder: What compares them.
        smallest_angle_deg: Nearer than that, the later of two is redrawn; 0 redraws nobody.
        most_redraws: Per person.
        camera: Gives every picture its exposure; they are enrolled ones, without its flaws.
        model: ONNX embedder in place of the shipped one, with its contract beside it.
        device: Where it runs; see :func:`lrsr.onnx.providers_on`.

    Raises:
        InputError: A number is out of its range.
    """

    gallery: Sitting
    encoder: Literal["dlib", "shipped"]
    smallest_angle_deg: float
    most_redraws: int
    camera: Camera
    model: Path | None = None
    device: str = "cpu"

    def __post_init__(self) -> None:
        angle = self.smallest_angle_deg
        require(0 <= angle < 90, "smallest_angle_deg", angle, "0 to 90 degrees")
        require(self.most_redraws >= 0, "most_redraws", self.most_redraws, "at least 0")

    def describe(self) -> dict[str, Any]:
        """Return all of it in plain values."""
        names = ("encoder", "smallest_angle_deg", "most_redraws")
        told = {name: getattr(self, name) for name in names}
        return {"gallery": self.gallery.describe(), **told, "seed": self.gallery.seed}

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read the settings of ``lrsr identities`` from its composed configuration.

        Raises:
            InputError: A value is out of range, or dlib is asked for and not installed.
        """
        recognition = RecognitionSettings.from_config(config)
        known = recognition.landmarks == ("shared",)
        require(known, "recognition.landmarks", config.recognition.landmarks, "shared")
        alone = recognition == RecognitionSettings(recognition.model, device=recognition.device)
        told = (
            "recognition.model and .device alone: nothing else is read; encoder= says who compares"
        )
        require(alone, "recognition", "...", told)
        encoder = resolve_encoder(str(config.encoder))
        given = config.smallest_angle_deg is not None
        least = number(config, "smallest_angle_deg") if given else SMALLEST_ANGLE_DEG[encoder]
        return cls(
            gallery=read_gallery(config),
            encoder=encoder,
            smallest_angle_deg=least,
            most_redraws=whole_number(config, "most_redraws"),
            camera=build(config.camera, "camera"),
            model=recognition.model,
            device=recognition.device,
        )


@dataclass(frozen=True)
class Gallery:
    """Everyone's enrolled picture and embedding, made when it is first asked for.

    Attributes:
        settings: Who, and how they are pictured.
        cache: Where renderings are kept.
        encoder: Embeds.
        maker: Renders what the cache lacks.
        progress: Show bars on stderr.
        people: What is recorded of everyone who was embedded, where it is known.
        embeddings: Of everyone so far.
    """

    settings: UniquenessSettings
    cache: RenderCache
    encoder: Recogniser
    maker: Maker
    progress: bool = True
    people: dict[Drawn, Traits | None] = field(default_factory=dict)
    embeddings: dict[Drawn, NDArray[np.float32]] = field(default_factory=dict)

    def recipe(self, drawn: Drawn) -> Recipe:
        """Return what somebody is rendered as; the same as the gallery of ``lrsr eval``."""
        (index, redraw), sitting = drawn, self.settings.gallery
        person = sitting.people.person(index)
        if isinstance(person, Person):
            person = replace(person, draw=person.draw + redraw)
        return sitting.recipe(person)

    def source(self, drawn: Sequence[Drawn]) -> Rendered:
        """Return the pictures of people."""
        recipes, camera = [self.recipe(one) for one in drawn], self.settings.camera.clean()
        return Rendered(recipes, camera, self.cache, self.maker, self.progress)

    def embed(self, drawn: Sequence[Drawn]) -> NDArray[np.float32]:
        """Render, photograph and embed people; return ``(n, D)``.

        Raises:
            InputError: The cache cannot be read or written.
        """
        source = self.source(drawn)
        render_sources([source])
        with tqdm(
            total=len(drawn), desc="comparing", unit="face", disable=not self.progress
        ) as bar:
            for place, pictures in chunks(source):
                images, landmarks = stack(pictures)
                rows = self.encoder.embed(images, landmarks.numpy())
                traits = [picture.traits for picture in pictures]
                self.embeddings.update(zip(drawn[place], rows, strict=True))
                self.people.update(zip(drawn[place], traits, strict=True))
                bar.update(len(pictures))
        return np.stack([self.embeddings[one] for one in drawn])


@dataclass(frozen=True)
class Findings:
    """What came out.

    Attributes:
        drawn: Who is left, in the order of the indices.
        names: Of everyone who was drawn, dismissed ones too.
        people: What is recorded of everyone left.
        angles_deg: Between all pairs of those left.
        first_angles_deg: Between all pairs of the first draws.
        pairs: The nearest pairs of those left; the rows count in ``drawn``.
        outcome: Who was redrawn, and why.
    """

    drawn: tuple[Drawn, ...]
    names: Mapping[Drawn, str]
    people: tuple[Traits, ...]
    angles_deg: NDArray[np.float32]
    first_angles_deg: NDArray[np.float32]
    pairs: tuple[Pair, ...]
    outcome: Distinct


def find_distinct(settings: UniquenessSettings, gallery: Gallery) -> Findings:
    """Redraw look-alikes until there are none, and say what is left.

    Raises:
        InputError: The cache cannot be read or written.
    """
    people = settings.gallery.people
    indices = range(people.start, people.start + people.count)
    outcome = draw_distinct(
        indices,
        gallery.embed,
        smallest_angle_deg=settings.smallest_angle_deg,
        most_redraws=settings.most_redraws if people.photographs is None else 0,
    )
    drawn = tuple(zip(indices, outcome.draws, strict=True))
    rows, firsts = (
        np.stack([gallery.embeddings[one] for one in some])
        for some in (drawn, [(index, 0) for index in indices])
    )
    return Findings(
        drawn=drawn,
        names={one: gallery.recipe(one).person.id for one in gallery.embeddings},
        people=tuple(filter(None, (gallery.people[one] for one in drawn))),
        angles_deg=pairwise_angles_deg(rows),
        first_angles_deg=pairwise_angles_deg(firsts),
        pairs=tuple(closest_pairs(rows, _NEAREST)),
        outcome=outcome,
    )


def make_roster(settings: UniquenessSettings, findings: Findings, recipe_version: str) -> Roster:
    """Return the roster of those left; redraws of a roster that was gone on from are added."""
    people = settings.gallery.people
    return Roster(
        split=people.split,  # type: ignore[arg-type]  # checked to be a split
        start=people.start,
        count=people.count,
        population=people.cast.population,
        recipe=recipe_version,
        encoder=settings.encoder,
        angle_deg=settings.smallest_angle_deg,
        draws={
            index: draw
            for index, redraw in findings.drawn
            if (draw := redraw + people.cast.draw(people.split, index))
        },
        unresolved=findings.outcome.unresolved,
    )


def summary(findings: Findings) -> dict[str, Any]:
    """Return the findings as plain values.

    Returns:
        JSON-serialisable: ``people``, ``compared`` (those with a face), ``angles_deg`` (of those
        left), ``first_angles_deg`` (before anybody was redrawn), ``histogram``, ``nearest_pairs``,
        ``rejected``, ``unresolved``.
    """
    counts, edges = np.histogram(findings.angles_deg, bins=np.arange(0.0, 181.0, 1.0))
    pairs = len(findings.angles_deg)
    left = {index: findings.names[index, draw] for index, draw in findings.drawn}
    return {
        "people": len(findings.drawn),
        "compared": round((1 + (1 + 8 * pairs) ** 0.5) / 2) if pairs else 0,
        "angles_deg": summarise(findings.angles_deg),
        "first_angles_deg": summarise(findings.first_angles_deg),
        "histogram": {"edges_deg": edges.tolist(), "pairs": counts.tolist()},
        "nearest_pairs": [
            {
                "first": findings.names[findings.drawn[pair.first]],
                "second": findings.names[findings.drawn[pair.second]],
                "angle_deg": pair.angle_deg,
            }
            for pair in findings.pairs
        ],
        "rejected": [
            {
                "who": findings.names[index, draw],
                "too_near_to": left[near],
                "angle_deg": angle,
            }
            for index, draw, near, angle in findings.outcome.rejected
        ],
        "unresolved": [left[index] for index in findings.outcome.unresolved],
    }
