"""How does a photograph become a head? Landmarks, a fit, a texture without its light.

The head has the parts, faces, uv and texture sizes of :func:`lrsr.identities.morphable.sample_head`
and can act, be turned, lit and dressed as any other. The same file and settings give the same
bytes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.day.another_day import SAME_DAY, AnotherDay
from lrsr.identities.day.worn import dress
from lrsr.identities.face.expression import NEUTRAL, Expression
from lrsr.identities.face.eyes import eyeball_vertices, find_eyes, unit_ball
from lrsr.identities.face.lashes import lash_faces
from lrsr.identities.face.lids import clear_lids, lid_margins
from lrsr.identities.face.mouth import JAW_UNITS, build_mouth, cavity, lining
from lrsr.identities.face.resting import RestingFace, acting_skin, place_face
from lrsr.identities.face.template import template
from lrsr.identities.hair.hair import build_hair
from lrsr.identities.hair.styles import style_parameters
from lrsr.identities.head import Head, Part
from lrsr.identities.photographs.choices import Hair, Kept
from lrsr.identities.photographs.eyes import photographed_eye
from lrsr.identities.photographs.fit import Fit
from lrsr.identities.photographs.foreground import find_person
from lrsr.identities.photographs.hair import paint_hair
from lrsr.identities.photographs.irises import IrisFinder, gazes_through
from lrsr.identities.photographs.mouth import (
    lips_are_parted,
    paint_sheet,
    painted_faces,
    skin_with_sheet,
)
from lrsr.identities.photographs.outlines import FACE, filled
from lrsr.identities.photographs.picture_file import Photograph
from lrsr.identities.photographs.quality import Quality, glasses_edge
from lrsr.identities.photographs.reconstructor import Reconstructor, shared_reconstructor
from lrsr.identities.photographs.shot import Mesh, take_shot
from lrsr.identities.photographs.skin import paint_photographed, plain_maps
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.position_map import Raster, cover

Map = NDArray[np.float32]
Points = NDArray[np.float64]

_LASHES = (2, 520)
"""Vertices of both eyes' lashes: the photograph has them, so the mesh is folded up in the eye."""
_LASH_ALBEDO = 0.015
_OF_WHOM = {"hair_colour": [0.03, 0.02, 0.015], "grey": 0.0}
"""Of the hair that lies sunk under the skull, unseen."""


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """A photographed person.

    Attributes:
        fit: The face that was fitted.
        quality: How well.
        face: At rest, in the head frame.
        albedo: ``(S, S, 3)`` of the skin.
        eyes: Both eyeballs.
        parted: Teeth are seen on the photograph, and painted on a sheet behind the lips.
        kept: Whether the head has the photograph's expression, or none.
    """

    fit: Fit
    quality: Quality
    face: RestingFace
    albedo: Map
    eyes: tuple[Part, Part]
    parted: bool
    kept: Kept

    def coarse(self) -> Points:
        """Return the coarse skin of the face as it was photographed, head frame, mm."""
        shaped = load_basis().shape(self.fit.acting).skin
        return np.asarray((shaped - self.face.origin) @ self.face.rotation.T)

    def head(
        self,
        name: str,
        parameters: Mapping[str, object],
        expression: Expression = NEUTRAL,
        another_day: AnotherDay = SAME_DAY,
        seed: int = 0,
    ) -> Head:
        """Build the head.

        Args:
            name: Of the person.
            parameters: Plain values of where it comes from.
            expression: What the face does beyond what it keeps of the photograph.
            another_day: What is worn; nothing else of another day is known of a photograph.
            seed: Of the person, for what is worn.
        """
        surface, face = load_basis().surface, self.face
        base = self.fit.acting if self.kept == "photograph" else self.fit.rest
        acting = expression.act(load_basis(), base)
        sheet = self.parted and self.kept == "photograph"
        if sheet:
            points = skin_with_sheet(face, acting)
        else:
            points = cavity().hollow(acting_skin(face, acting))
        skin = clear_lids(points, face.eyes, template().lids).astype(np.float32)
        maps = plain_maps(len(self.albedo))
        albedo = self.albedo
        if not sheet:
            albedo = albedo.copy()
            lining(len(albedo)).paint(albedo)
        parts: tuple[Part, ...] = (
            Part(
                "skin", "skin", skin, surface.faces, surface.uv, albedo,
                maps.height, np.ones_like(maps.roughness),  # the shine is painted
            ),
            *self.eyes,
            _folded_lashes(face),
            build_hair(_shaved(), skin, 0),
            _mouth(face, acting, folded=sheet),
        )  # fmt: skip
        landmarks = np.concatenate([face.eyes.pupils, points[surface.landmarks]])
        parts, worn = dress(parts, face.eyes.pupils, landmarks, another_day, seed)
        told = dict(parameters) | ({} if another_day.is_same else {"another_day": worn})
        return Head(name, parts, face.eyes.pupils, landmarks, told)


def reconstruct(
    photograph: Photograph,
    *,
    reconstructor: Reconstructor | None = None,
    texture_size: int = 1024,
    hair: Hair = "painted",
    kept: Kept = "photograph",
) -> Reconstruction:
    """Reconstruct the person of a photograph.

    Args:
        photograph: Of :func:`lrsr.identities.photographs.picture_file.frame`.
        reconstructor: The network that finds the face; the one that ships when None.
        texture_size: Rows and columns of the skin's texture, >= 64.
        hair: "painted" on the skull, or "none": a face in a void.
        kept: The "photograph"'s expression, or a "neutral" one.

    Raises:
        InputError: No cheeks or nose are seen where the face was fitted.
    """
    srgb = photograph.srgb
    found = (reconstructor or shared_reconstructor())(srgb, photograph.five_px)
    fit = found.fit
    pupils_px = _shared_iris_finder()(srgb, found.points_px)
    eyes_at_rest = find_eyes(load_basis(), load_basis().shape(fit.rest))
    face = place_face(fit.rest, gazes_through(eyes_at_rest, fit.perspective, pupils_px))
    perspective = fit.perspective.moved_axes(face.rotation, face.origin)
    shot = take_shot(srgb, perspective, found.points_px, face.eyes.pupils)
    parted = lips_are_parted(shot)
    points = (skin_with_sheet if parted else acting_skin)(face, fit.acting)
    ball = unit_ball()
    skin = Mesh(points, painted_faces(), load_basis().surface.uv)
    balls = [
        Mesh(eyeball_vertices(face.eyes, which).astype(np.float64), ball.faces, ball.uv)
        for which in (0, 1)
    ]
    depths = shot.depths([skin, *balls])
    seen = shot.texels(skin, texture_size, depths, _skin_raster(texture_size))
    shape = shot.linear.shape[:2]
    oval = filled(shot.points_px, FACE, (shape[0], shape[1]))
    painted = paint_photographed(shot, seen, oval)
    albedo = painted.albedo
    if hair == "painted":
        person = find_person(shot, depths.covered((shape[0], shape[1])), oval)
        albedo = paint_hair(painted, shot, seen, person)
    if parted:
        albedo = paint_sheet(albedo, shot, seen, painted.gain)
    margins = lid_margins(points, face.eyes, template().lids)
    eyes = [
        photographed_eye(shot, face.eyes, which, margins, painted.gain, depths) for which in (0, 1)
    ]
    yaw, pitch, roll = perspective.angles_deg
    measured = Quality(
        ipd_px=photograph.ipd_px,
        score=found.score,
        yaw_deg=yaw,
        pitch_deg=pitch,
        roll_deg=roll,
        distance_m=1 / perspective.nearness / 1000,
        residual_mm=float(np.median(fit.residual_mm)),
        strangeness=fit.strangeness,
        glasses_edge=glasses_edge(srgb, found.points_px),
        seen=painted.seen,
        unevenness=painted.unevenness,
        tint=painted.tint,
    )
    return Reconstruction(fit, measured, face, albedo, (eyes[0], eyes[1]), parted, kept)


@lru_cache(maxsize=2)
def _skin_raster(texture_size: int) -> Raster:
    return cover(load_basis().surface.uv, painted_faces(), texture_size)


@lru_cache(maxsize=1)
def _shared_iris_finder() -> IrisFinder:
    return IrisFinder()


def _shaved() -> dict[str, object]:
    return style_parameters("shaved", np.random.default_rng(0)) | _OF_WHOM


def _folded_lashes(face: RestingFace) -> Part:
    vertices = np.repeat(face.eyes.centres.astype(np.float32), _LASHES[1], axis=0)
    uv = np.full((len(vertices), 2), 0.5, np.float32)
    albedo = np.full((4, 4, 3), _LASH_ALBEDO, np.float32)
    return Part("lashes", "lash", vertices, lash_faces(), uv, albedo)


def _mouth(face: RestingFace, acting: Points, *, folded: bool) -> Part:
    """Make teeth and tongue; folded up in the throat where the photograph's are painted."""
    column = load_basis().column
    units = {unit: float(acting[column[f"unit/{unit}"]]) for unit in JAW_UNITS}
    mouth = build_mouth(face.shape, units, age=0.3)
    if not folded:
        return mouth
    inside = mouth.vertices.mean(axis=0) - np.array([0, 0, 40], np.float32)
    vertices = np.broadcast_to(inside, mouth.vertices.shape).astype(np.float32)
    return Part(mouth.name, mouth.material, vertices, mouth.faces, mouth.uv, mouth.albedo)
