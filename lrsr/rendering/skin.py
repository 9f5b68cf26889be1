"""What is skin made of? Models of it, as plain numbers with names."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, get_args

from lrsr.errors import InputError

SkinModel = Literal["reflective", "subsurface", "volumetric"]
Fixed = Literal["coefficients", "scattering"]
Colour = tuple[float, float, float]

CHANNEL_NM = (610.0, 550.0, 465.0)
"""Wavelengths that stand for red, green and blue where a spectrum is rendered."""


@dataclass(frozen=True)
class Skin:
    """How light and skin meet.

    Attributes:
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

    model: SkinModel = "subsurface"
    fixed: Fixed = "coefficients"
    absorption_per_mm: Colour = (0.032, 0.17, 0.48)
    scattering_per_mm: Colour = (0.74, 0.88, 1.01)
    refractive_index: float = 1.4
    reach_mm: float = 10.0

    def __post_init__(self) -> None:
        for key in ("absorption_per_mm", "scattering_per_mm"):
            object.__setattr__(self, key, tuple(float(x) for x in getattr(self, key)))
        absorbs, scatters = self.absorption_per_mm, self.scattering_per_mm
        wanted = {
            "model": (
                self.model in get_args(SkinModel),
                f"one of {', '.join(get_args(SkinModel))}",
            ),
            "fixed": (self.fixed in get_args(Fixed), f"one of {', '.join(get_args(Fixed))}"),
            "absorption_per_mm": (
                len(absorbs) == 3 and all(0 <= x < math.inf for x in absorbs),
                "three numbers >= 0",
            ),
            "scattering_per_mm": (
                len(scatters) == 3 and all(0 < x < math.inf for x in scatters),
                "three numbers > 0",
            ),
            "refractive_index": (1 < self.refractive_index <= 2, "a number > 1 and <= 2"),
            "reach_mm": (0 < self.reach_mm < math.inf, "a number of millimetres > 0"),
        }
        for name, (holds, wish) in wanted.items():
            if not holds:
                raise InputError(f"skin.{name}={getattr(self, name)}: wanted {wish}")

    @property
    def name(self) -> str:
        """Its name among :data:`SKINS`; of any other, the model's name with "own-" before it."""
        return next((name for name, skin in SKINS.items() if skin == self), f"own-{self.model}")

    def plain(self) -> str | dict[str, Any]:
        """Return all that changes pixels; of skin that reflects, that is the name alone."""
        return "reflective" if self.model == "reflective" else asdict(self)


SKINS = {
    "reflective": Skin("reflective"),
    "subsurface": Skin("subsurface"),
    "subsurface_tone": Skin("subsurface", "scattering"),
    "volumetric": Skin("volumetric"),
    "volumetric_tone": Skin("volumetric", "scattering"),
}
"""Skin models by name. The coefficients are those of "skin1" (Jensen et al. 2001, "A practical
model for subsurface light transport", Table 1: σa, and σs' which is reduced already), as in the
paper."""


def find_skin(skin: "str | Skin | Mapping[str, Any]", **changes: Any) -> Skin:
    """Return a skin by its name, from its fields, or the skin itself; ``changes`` replace fields.

    Raises:
        InputError: There is no skin of that name, no such field, or a value is out of range.

    Example:
        >>> find_skin("subsurface").scattering_per_mm
        (0.74, 0.88, 1.01)
    """
    if isinstance(skin, str):
        if skin not in SKINS:
            raise InputError(f"skin {skin!r} does not exist; choose one of {', '.join(SKINS)}")
        skin = SKINS[skin]
    given = changes if isinstance(skin, Skin) else {**skin, **changes}
    known = Skin.__dataclass_fields__
    for key in given:
        if key not in known:
            raise InputError(f"skin.{key} does not exist; choose of {', '.join(known)}")
    return replace(skin, **given) if isinstance(skin, Skin) else Skin(**given)


def named(skin: "str | Skin | Mapping[str, Any]") -> str | Skin:
    """Return the name of a skin that has one among :data:`SKINS`, else the skin.

    Raises:
        InputError: There is no such skin.

    Example:
        >>> named({"model": "subsurface", "fixed": "scattering"})
        'subsurface_tone'
    """
    found = find_skin(skin)
    return found.name if found.name in SKINS else found
