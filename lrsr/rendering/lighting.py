"""How is the face lit? Lightings as data: far discs, near panels, a fill or a map of the room.

What is infinitely far away (discs, fill, map) becomes one environment map; panels stand in the
room. A pose turns camera and lights around a head at rest, whose acceleration structure then serves
every pose.
"""

import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.configuration import as_parts, settle
from lrsr.errors import InputError
from lrsr.files import read_bytes
from lrsr.rendering.lights import NEW, Light, Panel, check_colour, colour_of, spare


@dataclass(frozen=True)
class Lighting:
    """All light that reaches the face, and with it the grey behind the head.

    Attributes:
        name: For manifests.
        lights: Far lights, or mappings of their fields; with the panels they may be none if
            ``fill_share`` is 1.
        fill_share: Share of the metered light that comes equally from everywhere, or from the map,
            0..1. An even fill is the backdrop too, which after exposure therefore always has this
            luminance.
        fill_rgb: Its colour; scaled so that its luminance is 1.
        panels: Near lights, or mappings of their fields.
        fill_kelvin: Colour temperature of the fill instead, 2000..25000 K.
        map: File of a latitude-longitude map (.exr, .hdr) that takes the place of the even fill,
            multiplied by its colour: zenith above, twice as wide as high, in its middle what the
            face looks at. Its scale does not matter.
        map_deg: Turns the map about the vertical: 90 brings what was in its middle to the image's
            right.
    """

    name: str
    lights: tuple[Light, ...] = field(default_factory=tuple)
    fill_share: float = 0.25
    fill_rgb: tuple[float, float, float] = (1.0, 1.0, 1.0)
    panels: tuple[Panel, ...] = field(default=(), metadata=NEW)
    fill_kelvin: float | None = field(default=None, metadata=NEW)
    map: str | None = field(default=None, metadata=NEW)
    map_deg: float = field(default=0.0, metadata=NEW)

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: A share outside 0..1, no light at all, a fill of no colour or two, or no
                such file.
        """
        settle(self, "lighting")
        for name, kind in (("lights", Light), ("panels", Panel)):
            parts = as_parts(kind, getattr(self, name), f"lighting.{name}")
            object.__setattr__(self, name, parts)
        count = len(self.lights) + len(self.panels)
        if not 0 <= self.fill_share <= 1 or (self.fill_share == 1) == bool(count):
            raise InputError(
                f"lighting {self.name!r}: fill_share={self.fill_share} with {count}"
                " lights; give 0 <= fill_share < 1 with lights, or 1 without"
            )
        check_colour(f"lighting {self.name!r}: fill_rgb", self.fill_rgb, self.fill_kelvin)
        if self.map is not None and not Path(self.map).is_file():
            raise InputError(f"lighting {self.name!r}: map={self.map} is no file; give an .exr")

    @property
    def fill_colour(self) -> NDArray[np.float64]:
        """Linear sRGB ``(3,)`` of luminance 1."""
        return colour_of(self.fill_rgb, self.fill_kelvin)

    def record(self) -> dict[str, Any]:
        """Return what makes this light and no other, in plain values; a file as its SHA-256.

        Fields that came later are left out while they have their defaults, so that what was
        recorded before stays true.
        """
        values = spare(self)
        values["lights"] = [spare(light) for light in self.lights]
        if self.map is not None:
            values["map"] = hashlib.sha256(read_bytes(Path(self.map))).hexdigest()
        return values
