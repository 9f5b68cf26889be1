"""What does a renderer need to know of a person? A :class:`Head`, and nothing else.

Head frame: millimetres, x to the subject's left, y up, z out of the face, the origin midway
between the pupils. Seen by a camera in front, +x is therefore on the image's **right**.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Material = Literal["skin", "eye", "hair", "lash", "plastic", "metal", "glass", "cloth"]

LANDMARK_NAMES = ("left_eye", "right_eye", "nose", "mouth_left", "mouth_right")
"""Order of the five ArcFace landmarks, named **as seen in the image** of a frontal face.

The image's left eye is the subject's right eye, so ``left_eye`` has the smaller x in the image and
the negative x in the head frame.
"""


@dataclass(frozen=True)
class Part:
    """One mesh of a head with its own texture.

    Attributes:
        name: What it is ("skin", "left_eye_ball", "scalp_hair", ...), unique within a head.
        material: How light meets it; the renderer owns the numbers.
        vertices: ``(V, 3)`` float32, head frame, mm.
        faces: ``(F, 3)`` int32, counter-clockwise seen from outside.
        uv: ``(V, 2)`` float32, in [0, 1]; v = 0 is the **top** row of ``albedo``.
        albedo: ``(H, W, 3)`` float32, linear sRGB reflectance, [0, 1].
        height: ``(H, W)`` float32, mm: relief too fine for the mesh, outwards from it, laid out as
            ``albedo`` (of any size); None for a smooth part.
        roughness: ``(H, W)`` float32, [0, 1], the square root of the microfacet slope α (Burley
            2012), laid out as ``albedo`` (of any size); None for the material's own number.
    """

    name: str
    material: Material
    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    uv: NDArray[np.float32]
    albedo: NDArray[np.float32]
    height: NDArray[np.float32] | None = None
    roughness: NDArray[np.float32] | None = None


@dataclass(frozen=True)
class Head:
    """One person, ready to be rendered.

    Two heads from the same maker have parts of the same names, in the same order, with the same
    faces, uv and texture sizes: only vertices and textures differ, so a scene is updated in place.

    Attributes:
        identity_id: Stable name; the same id is the same person, whose expression may differ.
        parts: Skin first.
        pupils: ``(2, 3)`` float64, mm, the image's left pupil first (negative x).
        landmarks: ``(5, 3)`` float64, mm, in the order of :data:`LANDMARK_NAMES`.
        parameters: Plain numbers and strings that made it; JSON-serialisable.
    """

    identity_id: str
    parts: tuple[Part, ...]
    pupils: NDArray[np.float64]
    landmarks: NDArray[np.float64]
    parameters: Mapping[str, object] = field(default_factory=dict)

    @property
    def ipd_mm(self) -> float:
        """Distance between the pupils, mm."""
        return float(np.linalg.norm(self.pupils[1] - self.pupils[0]))

    def part(self, name: str) -> Part:
        """Return the part of that name.

        Raises:
            KeyError: The head has no such part.
        """
        for part in self.parts:
            if part.name == name:
                return part
        raise KeyError(f"head {self.identity_id} has no part {name!r}")
