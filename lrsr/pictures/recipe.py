"""What is to be rendered? Everything that changes the light on the film, in frozen values."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, is_dataclass, replace
from typing import Any, Literal

from lrsr.configuration import LARGEST_SEED, as_whole
from lrsr.errors import InputError
from lrsr.identities.photographs.person import Somebody
from lrsr.identities.population import EVERYBODY
from lrsr.rendering.scene import Film, Quality, Scene
from lrsr.rendering.standpoint import LEVEL

Kind = Literal["probe", "gallery"]
KINDS = ("probe", "gallery")


@dataclass(frozen=True)
class Recipe:
    """One picture to be rendered, before the camera; equal recipes give equal pixels.

    Attributes:
        person: Who it shows.
        scene: What stands before the camera besides.
        film: Size and fineness.
        quality: How well it is rendered, at this very size.
        seed: Of the sampler, 0 to 2**32 - 1; :meth:`seeded` makes one for each picture.

    Raises:
        InputError: The seed is out of its range.
    """

    person: Somebody
    scene: Scene
    film: Film
    quality: Quality
    seed: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "seed", as_whole(self.seed, "seed"))
        if not 0 <= self.seed <= LARGEST_SEED:
            raise InputError(f"seed={self.seed}: wanted 0 to {LARGEST_SEED}")

    def seeded(self, seed: int, kind: Kind, frame: int = 0) -> "Recipe":
        """Return the same picture with a sampler's seed that follows from the run's.

        Two people, sizes or named conditions never share a noise pattern. Two scenes of the same
        names do, such as one lighting with another share of fill: what differs between their
        pictures is then the light, not the noise.

        Args:
            seed: The run's.
            kind: What the picture is for; an enrolled picture and a probe have other noise.
            frame: Of a burst: each has noise of its own.

        Raises:
            InputError: The seed is no whole number.
        """
        person, scene = self.person, self.scene
        what = [person.split, person.index, kind, scene.pose.name, scene.lighting.name]
        other = [person.population] if person.population != EVERYBODY else []
        redrawn = [person.draw] if person.draw else []
        acted = [scene.expression] if scene.expression.units else []
        later = [] if scene.another_day.is_same else [{"another_day": scene.another_day.record()}]
        seen = [self._seen()] if self._seen() else []
        still = [*other, *redrawn, *acted, *later, *seen]
        words = [
            *what,
            self.film.ipd_px,
            self.film.scale,
            *still,
            *([{"frame": frame}] * (frame > 0)),
        ]
        return replace(self, seed=derived_seed(as_whole(seed, "seed"), *words))

    def _seen(self) -> dict[str, Any]:
        """Return lens and standpoint in plain values; a level pinhole is left out."""
        lens, place = self.scene.lens, self.scene.standpoint.record()
        seen = {} if lens.is_pinhole else {"lens": lens.record()}
        return seen if place == LEVEL.record() else {**seen, "standpoint": place}

    def plain(self, versions: Mapping[str, str]) -> dict[str, Any]:
        """Return everything that changes the pixels, as numbers, strings, lists and mappings.

        Names are left out: equal numbers are equal pictures, whatever somebody calls them.

        Args:
            versions: Of the code that makes them, e.g. ``{"renderer": "3", "variant": ...}``.
        """
        pose, lighting = asdict(self.scene.pose), self.scene.lighting.record()
        day = self.scene.another_day
        for named in (pose, lighting):
            del named["name"]
        return {
            "person": self.person.record(),
            "pose": pose,
            "lighting": lighting,
            "expression": dict(self.scene.expression.units),
            **({} if day.is_same else {"another_day": day.record()}),
            **self._seen(),
            "film": self.film.record(),
            "quality": self.quality.plain(),
            "seed": self.seed,
            "versions": dict(versions),
        }


def digest(values: Mapping[str, Any]) -> str:
    """Return the SHA-256 (64 hex digits) of the canonical JSON of plain values.

    Raises:
        TypeError: A value is no plain number, string, list or mapping.
        ValueError: A value is a NaN or an infinity.

    Example:
        >>> digest({"a": 1, "b": 2.0}) == digest({"b": 2.0, "a": 1})
        True
    """
    return hashlib.sha256(canonical(values)).hexdigest()


def canonical(values: Mapping[str, Any]) -> bytes:
    """Return plain values as JSON without blanks, keys sorted; see :func:`digest`."""
    return json.dumps(values, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def derived_seed(seed: int, *what: object) -> int:
    """Return a 32-bit seed that depends on ``seed`` and on every word of ``what``.

    Args:
        seed: The run's.
        what: Plain values or dataclasses of them, e.g. identity, pose's name, size.

    Example:
        >>> derived_seed(0, "train-00000", "left") == derived_seed(0, "train-00000", "up")
        False
    """
    plain = [asdict(x) if is_dataclass(x) and not isinstance(x, type) else x for x in what]
    text = json.dumps([seed, *plain], sort_keys=True)
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big")
