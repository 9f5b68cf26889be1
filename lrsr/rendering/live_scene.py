"""The live Mitsuba scene: a head at rest in an environment of light, changed in place.

Loading a scene compiles kernels, and other live scenes make every kernel longer, so there is one
:class:`LiveScene` per renderer. A head of the same topology replaces the last one's vertices and
textures; poses turn the light (and the camera) instead of the head.
"""

import gc
import logging
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from lrsr.errors import InputError
from lrsr.identities.head import Head, Part
from lrsr.rendering.backend import alone, mi
from lrsr.rendering.environment import environment
from lrsr.rendering.geometry import world_to_head
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.live_lights import describe_panels, map_data, move_panels, opaque_transform
from lrsr.rendering.materials import CLEAR, MATERIALS, bsdf
from lrsr.rendering.painted_skin import SkinSurface
from lrsr.rendering.pose import Pose
from lrsr.rendering.skin import Skin
from lrsr.rendering.skin_medium import (
    LONGEST_PATH,
    describe_boundary,
    describe_medium,
    medium_parameters,
)
from lrsr.rendering.skin_spectrum import VALUES, skin_albedo
from lrsr.rendering.subsurface import subsurface_integrator

_PANES = 4
"""Edges of a path that panes of glass may add: in and out, towards a face and back."""

logger = logging.getLogger(__name__)


class LiveScene:
    """One scene that lives on.

    Args:
        skin: How light meets skin.
    """

    def __init__(self, skin: Skin) -> None:
        self.skin = skin
        self._surfaces: list[Any] = []
        self._integrator: Any = None
        self._scene: Any = None
        self._parameters: Any = None
        self._keys: dict[tuple[str, str], str] = {}
        self._around: dict[str, Any] = {}
        self._head: Head | None = None
        self._lighting: Lighting | None = None
        self._panels = 0
        self._pose: Pose | None = None

    def __del__(self) -> None:
        """Let go of the scene while nobody renders: a virtual call goes through all that live."""
        with suppress(InputError), alone():  # which a forked child may not
            self.__dict__.clear()

    def show(self, head: Head, lighting: Lighting, pose: Pose) -> Any:
        """Return the ``mi.Scene`` with that head in that light, as seen from the head's frame."""
        shown = self._head
        if shown is None or len(lighting.panels) != self._panels or not _fits(head, shown):
            self._load(head, lighting)
        elif head is not shown:
            self._update_head(head, shown)
        if lighting != self._lighting or pose != self._pose:
            self._update_light(lighting, pose)
        return self._scene

    def integrator(self, max_depth: int, roulette_depth: int) -> Any:
        """Return what traces the scene that was shown last, always with the same two numbers.

        Args:
            max_depth: Longest path, in edges from the camera; edges through glasses are further.
            roulette_depth: From which bounce on dim paths may end by chance.
        """
        if self._integrator is None:
            max_depth += _PANES if self._is_glazed() else 0
            depths = (max_depth, roulette_depth)
            kind = "volpath" if self._is_glazed() else "path"  # whose lights shine through panes
            path = {"type": kind, "max_depth": max_depth, "rr_depth": roulette_depth}
            if self._model() == "volumetric":
                path = {"type": "volpathmis", "max_depth": LONGEST_PATH}
            self._integrator = (
                subsurface_integrator(self.skin, self._surfaces, *depths, glazed=self._is_glazed())
                if self._surfaces
                else mi.load_dict(path)
            )
        return self._integrator

    def _is_glazed(self) -> bool:
        shown = self._head
        return shown is not None and any(part.material == CLEAR for part in shown.parts)

    def _model(self) -> str:
        if mi.variant().startswith("scalar") and self.skin.model == "subsurface":
            _warn_of_scalar()
            return "reflective"
        return self.skin.model

    def _load(self, head: Head, lighting: Lighting) -> None:
        self._scene = self._parameters = self._head = self._lighting = self._pose = None
        self._integrator = None
        self._surfaces = []
        self._keys = {}
        gc.collect()  # Dr.Jit compiles virtual calls for everything that is alive
        light = {"type": "envmap", "bitmap": mi.Bitmap(environment(lighting)[0].copy())}
        parts = {part.name: self._mesh(part) for part in head.parts}
        panels = describe_panels(lighting)
        self._panels = len(lighting.panels)
        self._scene = mi.load_dict({"type": "scene", "light": light, **parts, **panels})
        self._parameters = mi.traverse(self._scene)
        self._head, self._lighting = head, lighting

    def _mesh(self, part: Part) -> Any:
        properties = mi.Properties()
        translucent = part.material == "skin" and self._model() == "volumetric"
        given = [] if translucent else _textures(part)
        textures = {name: _painted(part, name, values) for name, values in given}
        if translucent:
            properties["bsdf"] = mi.load_dict(describe_boundary(self.skin))
            properties["interior"] = mi.load_dict(describe_medium(self.skin, part))
        else:
            description, keys = bsdf(MATERIALS[part.material], textures)
            self._keys |= {(part.name, name): f"{part.name}.bsdf.{keys[name]}" for name in keys}
            if part.material == "skin" and mi.is_spectral:
                key = self._keys[part.name, "albedo"]
                self._keys[part.name, "albedo"] = f"{key.removesuffix('data')}{VALUES}"
            properties["bsdf"] = mi.load_dict(description)
        has = {"has_vertex_normals": True, "has_vertex_texcoords": True}
        mesh = mi.Mesh(part.name, len(part.vertices), len(part.faces), properties, **has)
        values = mi.traverse(mesh)
        values["faces"] = np.ascontiguousarray(part.faces, dtype=np.uint32).ravel()
        values["vertex_texcoords"] = part.uv.ravel()
        values["vertex_positions"] = part.vertices.ravel()
        self._around[part.name] = _faces_around(part.faces, len(part.vertices))
        normals = _vertex_normals(part.vertices, part.faces, self._around[part.name])
        values["vertex_normals"] = normals.ravel()
        values.update()
        if part.material == "skin" and self._model() == "subsurface":
            self._surfaces.append(_skin_surface(mesh, textures))
        return mesh

    def _update_head(self, head: Head, shown: Head) -> None:
        for new, old in zip(head.parts, shown.parts, strict=True):
            if not _same(new.vertices, old.vertices):
                normals = _vertex_normals(new.vertices, new.faces, self._around[new.name])
                self._parameters[f"{new.name}.vertex_positions"] = new.vertices.ravel()
                self._parameters[f"{new.name}.vertex_normals"] = normals.ravel()
            for (name, texture), (_, before) in zip(_textures(new), _textures(old), strict=True):
                if not _same(texture, before):
                    self._update_texture(new, name, texture)
        self._parameters.update()
        self._head = head
        # Mitsuba hands the light the bounding sphere of the head before; a second update, of the
        # light alone, hands it this one's. Else the last bits would depend on who came before.
        self._pose = None

    def _update_texture(self, part: Part, name: str, texture: NDArray[np.float32]) -> None:
        if (part.name, name) in self._keys:
            if name == "albedo" and mi.is_spectral and part.material != "skin":
                # which stores colours as coefficients
                tensor = mi.traverse(_painted(part, name, texture))["data"]
            else:
                tensor = mi.TensorXf(np.ascontiguousarray(texture))
            self._parameters[self._keys[part.name, name]] = tensor
        elif name == "albedo":
            for key, value in medium_parameters(self.skin, part).items():
                self._parameters[f"{part.name}.interior_medium.{key}"] = value

    def _update_light(self, lighting: Lighting, pose: Pose) -> None:
        if lighting != self._lighting:
            width = self._parameters["light.data"].shape[1]
            self._parameters["light.data"] = map_data(environment(lighting)[0], width)
        move_panels(self._parameters, lighting, world_to_head(pose))
        self._parameters["light.to_world"] = opaque_transform(world_to_head(pose))
        self._parameters.update()
        self._lighting, self._pose = lighting, pose


def _fits(new: Head, old: Head) -> bool:
    """Tell whether a head can replace another in place: it differs in shape and colour alone."""

    def outline(part: Part) -> tuple[object, ...]:
        textures = [(name, texture.shape) for name, texture in _textures(part)]
        return part.name, part.material, part.vertices.shape, textures

    return [*map(outline, new.parts)] == [*map(outline, old.parts)] and all(
        _same(a.faces, b.faces) and _same(a.uv, b.uv)
        for a, b in zip(new.parts, old.parts, strict=True)
    )


def _same(new: NDArray[Any], old: NDArray[Any]) -> bool:
    return new is old or np.array_equal(new, old)


def _textures(part: Part) -> list[tuple[str, NDArray[np.float32]]]:
    """Return the textures that a part has by their names, each ``(H, W, channels)``."""
    if part.material == CLEAR:
        return []
    maps = (("height", part.height), ("roughness", part.roughness))
    given = [(name, texture[..., None]) for name, texture in maps if texture is not None]
    return [("albedo", part.albedo), *given]


def _painted(part: Part, name: str, texture: NDArray[np.float32]) -> Any:
    """Make a ``mi.Texture`` of a map of a part, ``(H, W, channels)``.

    Where light has a spectrum, albedo of skin has skin's, and another albedo Mitsuba's.
    """
    coloured, skin = name == "albedo" and mi.is_spectral, part.material == "skin"
    values = mi.Bitmap(np.array(texture, dtype=np.float32, order="C"))
    raw = {"type": "bitmap", "bitmap": values, "raw": not coloured or skin, "wrap_mode": "clamp"}
    return skin_albedo(mi.load_dict(raw)) if coloured and skin else mi.load_dict(raw)


def _skin_surface(mesh: Any, textures: Mapping[str, Any]) -> Any:
    """Return what the tracer of translucent skin needs to know of a mesh with those textures."""
    roughness = textures.get("roughness")
    if roughness is None:
        number = MATERIALS["skin"]["roughness"]
        roughness = mi.load_dict({"type": "uniform", "value": number})
    return SkinSurface(mesh, textures["albedo"], roughness, textures.get("height"))


@cache
def _warn_of_scalar() -> None:
    logger.warning("translucent skin needs LLVM or CUDA: it is drawn reflective instead")


def _faces_around(faces: NDArray[np.int32], vertices: int) -> csr_array:
    """Return the ``(V, F)`` matrix of ones that adds up what belongs to the faces at a vertex."""
    corners = faces.ravel()
    order = np.argsort(corners, kind="stable")
    ends = np.cumsum(np.bincount(corners, minlength=vertices))
    ones = np.ones(corners.size)
    return csr_array((ones, order // 3, np.append(0, ends)), shape=(vertices, len(faces)))


def _vertex_normals(
    vertices: NDArray[np.float32], faces: NDArray[np.int32], around: csr_array
) -> NDArray[np.float32]:
    """Average the faces' normals at each vertex, weighted by area.

    Mitsuba would add them up in whatever order its threads run; this order is fixed, so the same
    head is the same bytes.

    Args:
        vertices: ``(V, 3)``.
        faces: ``(F, 3)``, counter-clockwise seen from outside.
        around: Of ``_faces_around``.

    Returns:
        ``(V, 3)`` float32, unit length; (0, 0, 1) at a vertex without faces.
    """
    points = vertices.astype(np.float64)
    first, second, third = (points.take(corner, axis=0) for corner in faces.T)
    sums = around @ np.cross(second - first, third - first)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    sums = np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1), (0.0, 0.0, 1.0))
    return sums.astype(np.float32)
