"""What is to be rendered? Everything that changes the light on the film, in plain values."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, is_dataclass, replace
from typing import Any, Literal

from lrsr.errors import InputError
from lrsr.identities.face.expression import Expression, find_expression
from lrsr.identities.population import EVERYBODY, Population
from lrsr.identities.splits import SPLITS, Split
from lrsr.rendering.lens import Lens, find_lens
from lrsr.rendering.scene import Lighting, Pose, find_lighting, find_pose
from lrsr.rendering.skin import Skin, find_skin, named
from lrsr.rendering.standpoint import Standpoint, find_standpoint

Kind = Literal["probe", "gallery"]
KINDS = ("probe", "gallery")
SCALES = (1, 2, 4)


@dataclass(frozen=True)
class ProbeRecipe:
    """One picture to be rendered, before the camera; equal recipes give equal pixels.

    Attributes:
        split: Which people; the three splits have nobody in common.
        index: Number of the person within the split, >= 0.
        kind: What the picture is for. It does not change the scene.
        pose: Name of a pose, or one with any angles.
        lighting: Name of a lighting, or one with any lights.
        ipd_px: Interpupillary distance of the frontal face on the ×1 film, px, > 0.
        scale: How many times finer than the ×1 film: 1, 2 or 4.
        samples_per_pixel: Of the ×1 film; a finer film spreads the same rays over more pixels.
        seed: Of the sampler, 0 to 2**32 - 1; :func:`derived_seed` makes one for each picture.
        texture_size: Of the head's albedo, px.
        skin: Name of a skin, or any other; see :mod:`lrsr.rendering.skin`.
        max_depth: Longest light path.
        population: From whom the person is drawn.
        draw: How often the person was redrawn; see :mod:`lrsr.identities.roster`.
        expression: Name of an expression, or one with any face units.
        lens: Name of a lens, or any surfaces.
        standpoint: Name of a place of the camera, or any.
        bands: Spectral bands on the film, 7 to 350; 0: three colours. See
            :mod:`lrsr.spectra`.

    Raises:
        InputError: A value is out of its range, or there is no such pose, lighting, expression,
            lens or standpoint.
    """

    split: Split
    index: int
    kind: Kind = "probe"
    pose: str | Pose = "frontal"
    lighting: str | Lighting = "frontal"
    ipd_px: float = 8.0
    scale: int = 1
    samples_per_pixel: int = 2048
    seed: int = 0
    texture_size: int = 1024
    skin: str | Skin = "reflective"
    max_depth: int = 5
    population: Population = EVERYBODY
    draw: int = 0
    expression: str | Expression = "neutral"
    lens: str | Lens = "pinhole"
    standpoint: str | Standpoint = "level"
    bands: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "ipd_px", float(self.ipd_px))  # 8 and 8.0 are one picture
        object.__setattr__(self, "skin", named(self.skin))  # configurations hold numbers
        wanted = {
            "split": (self.split in SPLITS, f"one of {', '.join(SPLITS)}"),
            "kind": (self.kind in KINDS, f"one of {', '.join(KINDS)}"),
            "scale": (self.scale in SCALES, f"one of {SCALES}"),
            "index": (self.index >= 0, "a number >= 0"),
            "ipd_px": (0 < self.ipd_px < 2000, "a number of pixels > 0 and < 2000"),
            "samples_per_pixel": (self.samples_per_pixel >= 1, "a number >= 1"),
            "seed": (0 <= self.seed < 2**32, "0 to 4294967295"),
            "texture_size": (self.texture_size >= 8, "a number >= 8"),
            "max_depth": (self.max_depth >= 1, "a number >= 1"),
            "draw": (self.draw >= 0, "a number >= 0"),
            "bands": (self.bands == 0 or 7 <= self.bands <= 350, "0, or 7 to 350"),
        }
        for name, (holds, wish) in wanted.items():
            if not holds:
                raise InputError(f"{name}={getattr(self, name)}: wanted {wish}")
        find_pose(self.pose)
        find_lighting(self.lighting)
        find_expression(self.expression)
        find_lens(self.lens)
        find_standpoint(self.standpoint)

    @property
    def identity_id(self) -> str:
        """Stable name of the person: split and number, and what sets them apart from that one.

        Example:
            >>> ProbeRecipe("test", 7).identity_id
            'test-00007'
            >>> ProbeRecipe("test", 7, population=Population("female"), draw=1).identity_id
            'test-00007-female-draw1'
        """
        words = [self.split, f"{self.index:05d}", self.population.tag]
        return "-".join(filter(None, [*words, f"draw{self.draw}" if self.draw else ""]))

    def seeded(self, seed: int) -> "ProbeRecipe":
        """Return the same picture with a sampler's seed that follows from the run's.

        Two pictures with one sampler seed would carry the same noise pattern.

        Args:
            seed: The run's; whatever else is different about the picture changes it too.
        """
        what = [self.split, self.index, self.kind, self.pose, self.lighting, self.ipd_px]
        other = [self.population] if self.population != EVERYBODY else []
        redrawn = [self.draw] if self.draw else []
        acting = find_expression(self.expression)
        acted = [acting] if acting.units else []
        seen = [self._seen()] if self._seen() else []
        words = [*what, self.scale, *other, *redrawn, *acted, *seen]
        return replace(self, seed=derived_seed(seed, *words))

    def _seen(self) -> dict[str, Any]:
        """Return lens and standpoint in plain values; a level pinhole is left out."""
        lens, place = find_lens(self.lens), find_standpoint(self.standpoint)
        seen: dict[str, Any] = {} if lens.is_pinhole else {"lens": lens.record()}
        if place.record() != find_standpoint("level").record():
            seen["standpoint"] = place.record()
        return seen

    def plain(self, versions: Mapping[str, str]) -> dict[str, Any]:
        """Return everything that changes the pixels, as numbers, strings, lists and mappings.

        ``kind`` is left out: a gallery picture and a probe of the same light are the same pixels.
        Poses, lightings and expressions go in as angles, lights and face units, named or not;
        lenses and standpoints as surfaces and places, if the camera is no level pinhole. Bands
        go in if there are any.

        Args:
            versions: Of the code that makes them, e.g. ``{"renderer": "3", "variant": ...}``.
        """
        pose, lighting = find_pose(self.pose), find_lighting(self.lighting)
        values = asdict(replace(self, pose=pose, lighting=lighting))
        for name in ("kind", "lens", "standpoint", *([] if self.bands else ["bands"])):
            del values[name]
        values |= {"lighting": lighting.record(), **self._seen()}
        values["skin"] = find_skin(self.skin).plain()
        values["expression"] = dict(find_expression(self.expression).units)
        return {**values, "versions": dict(versions)}


def derived_seed(seed: int, *what: object) -> int:
    """Return a 32-bit seed that depends on ``seed`` and on every word of ``what``.

    Pictures rendered with the same sampler seed would carry the same noise pattern.

    Args:
        seed: The run's.
        what: Plain values or dataclasses of them, e.g. identity, pose, lighting, size.

    Example:
        >>> derived_seed(0, "train-00000", "left") == derived_seed(0, "train-00000", "up")
        False
    """
    text = json.dumps([seed, *map(_plain, what)], sort_keys=True)
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big")


def _plain(value: object) -> object:
    """Return what makes a dataclass in plain values; anything else as it is."""
    if isinstance(value, Lighting):
        return value.record()
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else value
