"""What stands before the camera, how fine is its film, and how well is it rendered? Frozen values.

Names of presets (``conf/pose/left.yaml``) become these values where a configuration is read:
:func:`lrsr.configuration.preset`.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any

from lrsr.configuration import require, settle
from lrsr.identities.day.another_day import SAME_DAY, AnotherDay
from lrsr.identities.face.expression import NEUTRAL, Expression
from lrsr.rendering.lens import PINHOLE, Lens
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.pose import FRONTAL, Pose
from lrsr.rendering.skin import REFLECTIVE, Skin
from lrsr.rendering.standpoint import LEVEL, Standpoint

_SCALES = (1, 2, 3, 4)

_LEAST_SAMPLES = 64
"""Samples a pixel of a large face, unless it is told to take fewer."""

FEWEST_ON_FINE = 16
"""No pixel of a fine film has fewer samples, unless the ×1 film is to have fewer."""


@dataclass(frozen=True)
class Scene:
    """What stands before the camera, but for who it is.

    Attributes:
        lighting: All light that reaches the face.
        pose: How the head is turned.
        lens: What the camera looks through.
        standpoint: Where the camera stands.
        expression: What the face does.
        another_day: What has changed since the person was enrolled, and what is worn.
    """

    lighting: Lighting
    pose: Pose = FRONTAL
    lens: Lens = PINHOLE
    standpoint: Standpoint = LEVEL
    expression: Expression = NEUTRAL
    another_day: AnotherDay = SAME_DAY

    def describe(self) -> dict[str, Any]:
        """Return all of it in plain values, names included."""
        return {
            "lighting": self.lighting.record(),
            "pose": asdict(self.pose),
            "lens": {"name": self.lens.name, **self.lens.record()},
            "standpoint": asdict(self.standpoint),
            "expression": asdict(self.expression),
            "another_day": asdict(self.another_day),
        }


@dataclass(frozen=True)
class Film:
    """How large and how fine the picture is.

    Attributes:
        ipd_px: Interpupillary distance of the frontal face on the ×1 film, px, > 0 and < 2000.
        scale: How many times finer than the ×1 film: 1, 2, 3 or 4.
        bands: Spectral bands, 7 to 350; 0: three colours. See :mod:`lrsr.spectra`.
        shift_px: (right, down) that all of the picture lies off, px of the ×1 film, each less than
            a quarter of an IPD.
        nearer: Share of the way to the camera that the face has come since its size was ``ipd_px``,
            -0.5 to 0.5; it is that much larger.

    Raises:
        InputError: A number is out of its range.
    """

    ipd_px: float = 8.0
    scale: int = 1
    bands: int = 0
    shift_px: tuple[float, float] = (0.0, 0.0)
    nearer: float = 0.0

    def __post_init__(self) -> None:
        settle(self, "")
        wish = "a number of pixels > 0 and < 2000"
        require(0 < self.ipd_px < 2000, "ipd_px", f"{self.ipd_px:g}", wish)
        require(self.scale in _SCALES, "scale", self.scale, f"one of {_SCALES}")
        require(self.bands == 0 or 7 <= self.bands <= 350, "bands", self.bands, "0, or 7 to 350")
        farthest, wish = max(map(abs, self.shift_px)), f"less than {self.ipd_px / 4:g} px"
        require(farthest < self.ipd_px / 4, "shift_px", self.shift_px, wish)
        require(abs(self.nearer) <= 0.5, "nearer", self.nearer, "-0.5 to 0.5")

    def record(self) -> dict[str, Any]:
        """Return it in plain values; what has not moved is left out."""
        still = {"shift_px": (0.0, 0.0), "nearer": 0.0}
        return {name: value for name, value in asdict(self).items() if value != still.get(name)}


_LIMITS = {
    "samples_per_pixel": (1, 2**24),
    "max_depth": (2, 2**16),
    "texture_size": (64, 8192),
}
"""Lowest and highest; of an albedo below 64 px nothing is left, and 8192 are 800 MB of floats."""


@dataclass(frozen=True)
class Quality:
    """How well light is traced, and what skin it meets.

    Attributes:
        samples_per_pixel: Of the ×1 film; a finer one spreads the same rays over more pixels.
        max_depth: Longest light path, in edges from the camera, >= 2; volumetric skin knows none.
        texture_size: Side of the head's albedo, px, 64 to 8192.
        skin: How light meets skin.

    Raises:
        InputError: A number is out of its range.
    """

    samples_per_pixel: int = 512
    max_depth: int = 5
    texture_size: int = 1024
    skin: Skin = REFLECTIVE

    def __post_init__(self) -> None:
        settle(self, "rendering")
        for name, (low, high) in _LIMITS.items():
            value = getattr(self, name)
            require(low <= value <= high, f"rendering.{name}", value, f"{low} to {high}")

    def plain(self) -> dict[str, Any]:
        """Return everything that changes the pixels in plain values.

        Fewer than :data:`FEWEST_ON_FINE` samples are marked, for what older caches keep of them has
        as many.
        """
        few = {"few": True} if self.samples_per_pixel < FEWEST_ON_FINE else {}
        return {**asdict(self), "skin": self.skin.plain(), **few}

    def at(self, ipd_px: float) -> "Quality":
        """Return the quality of a film of that size, where this one is that of 8 px.

        A larger face gets the same number of rays, so that it is as free of noise after alignment,
        but at least ``_LEAST_SAMPLES`` a pixel (or as many as this one has).

        Example:
            >>> Quality(512).at(16).samples_per_pixel
            128
        """
        fair = round(self.samples_per_pixel * min(1.0, 8 / ipd_px) ** 2)
        samples = min(self.samples_per_pixel, max(fair, _LEAST_SAMPLES))
        return replace(self, samples_per_pixel=samples)
