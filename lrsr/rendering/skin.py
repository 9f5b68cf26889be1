"""What is skin made of? Models of it, as plain numbers with names."""

from dataclasses import asdict, dataclass
from typing import Any, Literal

from lrsr.configuration import require, settle

_SkinModel = Literal["reflective", "subsurface", "volumetric"]
_Fixed = Literal["coefficients", "scattering"]
Colour = tuple[float, float, float]

CHANNEL_NM = (610.0, 550.0, 465.0)
"""Wavelengths that stand for red, green and blue where a spectrum is rendered."""


@dataclass(frozen=True)
class Skin:
    """How light and skin meet.

    Skin that reflects needs no number, translucent skin all of them (``conf/rendering/skin``).

    Attributes:
        name: For records; two skins of the same numbers make the same picture.
        model: ``reflective``: a surface that reflects on an opaque diffuse base (``principled``).
            ``subsurface``: light leaves elsewhere than it entered, by a diffusion profile.
            ``volumetric``: every scattering is traced in a homogeneous medium behind a dielectric
            boundary. The truth for that medium, but slow, and without the texture of albedos.
        fixed: What people have in common. ``coefficients``: all have the medium below; in
            ``subsurface`` its mean free path sets the width of the profile, the texture of albedos
            its height. ``scattering``: all scatter alike, and absorption follows from the albedo
            (of each point in ``subsurface``, the face's median in ``volumetric``): the darker
            the skin, the shorter the light's way.
        absorption_per_mm: σa of red, green and blue, mm⁻¹, >= 0.
        scattering_per_mm: Reduced σs', mm⁻¹, > 0.
        refractive_index: Of the medium, 1 < n <= 2; the fits are made for 1.4.
        reach_mm: Farthest distance between entry and exit, mm, > 0; the profile is cut there and
            scaled up, so that no light is lost.

    Raises:
        InputError: There is no such model, or a number is out of range.
    """

    name: str = "reflective"
    model: _SkinModel = "reflective"
    fixed: _Fixed = "coefficients"
    absorption_per_mm: Colour = (0.0, 0.0, 0.0)
    scattering_per_mm: Colour = (0.0, 0.0, 0.0)
    refractive_index: float = 1.0
    reach_mm: float = 0.0

    def __post_init__(self) -> None:
        settle(self, "skin")
        opaque = self.model == "reflective"
        for name, holds, wish in (
            ("absorption_per_mm", min(self.absorption_per_mm) >= 0, "three numbers >= 0"),
            ("scattering_per_mm", opaque or min(self.scattering_per_mm) > 0, "three numbers > 0"),
            ("refractive_index", opaque or 1 < self.refractive_index <= 2, "a number > 1 and <= 2"),
            ("reach_mm", opaque or self.reach_mm > 0, "a number of millimetres > 0"),
        ):
            require(holds, f"skin.{name}", getattr(self, name), wish)

    def plain(self) -> dict[str, Any]:
        """Return all that changes pixels: of skin that reflects, that it does."""
        values = asdict(self)
        del values["name"]
        return {"model": "reflective"} if self.model == "reflective" else values


REFLECTIVE = Skin()
"""Opaque skin, the fastest."""
