"""Which person does a seed stand for? A head of the CC0 shape space, with skin, eyes and hair.

``sample_head(seed)`` is the whole recipe: plain numbers are drawn once (:func:`sample_parameters`),
shape, skin, brows, beard, eyes and hair are made from them, so they agree with each other. Every
trait has a random stream of its own, so a change to one of them leaves the others as they were.
All people are adults.
"""

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.appearance import SkinMaps, SkinPainter, sample_appearance
from lrsr.identities.basis import BaseHead, Basis, load_basis
from lrsr.identities.expression import Expression, find_expression
from lrsr.identities.eyes import Eyes, eye_chart, eyeball_vertices, find_eyes, unit_ball
from lrsr.identities.hair import Scalp, build_hair, mean_colour, sample_hair
from lrsr.identities.head import Head, Part
from lrsr.identities.iris import paint_eye
from lrsr.identities.lashes import lash_faces, place_lashes
from lrsr.identities.lids import clear_lids, lid_margins, rest_lids
from lrsr.identities.mouth import JAW_UNITS, build_mouth, cavity, lining
from lrsr.identities.population import EVERYBODY, OLDEST_YEARS, YOUNGEST_YEARS, Population
from lrsr.identities.position_map import PositionMap, draw_triangles, fill_outside
from lrsr.identities.proportions import load_gauge
from lrsr.identities.relief import displace
from lrsr.identities.shape import RACES, coefficients, sample_anatomy
from lrsr.identities.template import template

RECIPE_VERSION = "5"
"""Changes whenever the same seed would give other pixels."""

STREAMS = ("person", "anatomy", "appearance", "hair", "eyes", "mouth")
"""One independent source of chance for each; append, never reorder."""

EYE_TEXTURE = 256
LASH_ALBEDO = 0.015


def stream(seed: int, name: str) -> Generator:
    """Return the random generator of one trait of one person.

    Args:
        seed: The person, >= 0.
        name: One of :data:`STREAMS`.

    Raises:
        ValueError: The seed is negative or the name unknown.
    """
    if seed < 0:
        raise ValueError(f"seed must be >= 0, got {seed}")
    return np.random.default_rng([seed, STREAMS.index(name)])


def _sample_masculinity(rng: Generator) -> float:
    """Draw a woman (0.02 to 0.25) or a man (0.75 to 0.98), evenly."""
    degree = 0.5 + 0.48 * float(rng.beta(2.0, 1.2))
    return 0.5 + 0.5 * degree if rng.random() < 0.5 else 0.5 - 0.5 * degree


def sample_parameters(seed: int, *, population: Population = EVERYBODY) -> dict[str, Any]:
    """Draw everything about a person, as plain numbers and names.

    Args:
        seed: >= 0.
        population: From whom.

    Returns:
        JSON-serialisable: ``sex``, ``masculinity`` (0..1), ``age`` (0..1), ``age_years`` (25..75),
        ``ancestry`` (shares of :data:`lrsr.identities.shape.RACES`), ``anatomy`` (see
        :class:`lrsr.identities.shape.Anatomy`), and what skin, eyes and hair need.

    Raises:
        ValueError: The seed is negative.
    """
    rng = stream(seed, "person")
    masculinity = population.masculinity(_sample_masculinity(rng))
    age = population.age(float(rng.beta(1.1, 1.5)))
    shares = population.shares(rng.dirichlet([0.25] * len(RACES)))
    ancestry = {race: float(share) for race, share in zip(RACES, shares, strict=True)}
    appearance = sample_appearance(
        stream(seed, "appearance"), masculinity=masculinity, age=age, ancestry=shares
    )
    hair = sample_hair(
        stream(seed, "hair"), masculinity, age, ancestry, colour=appearance["hair_colour"]
    )
    return {
        "seed": seed,
        "recipe": RECIPE_VERSION,
        "sex": "male" if masculinity >= 0.5 else "female",
        "masculinity": masculinity,
        "age": age,
        "age_years": YOUNGEST_YEARS + (OLDEST_YEARS - YOUNGEST_YEARS) * age,
        "ancestry": ancestry,
        "anatomy": sample_anatomy(
            load_basis().names,
            load_gauge(),
            stream(seed, "anatomy"),
            masculinity=masculinity,
            age=age,
        ),
        "appearance": appearance,
        "hair": hair,
    }


def _head_frame(eyes: Eyes) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return rotation and origin that put the pupils on the x axis, their middle at the origin."""
    left, right = eyes.pupils
    x = (right - left) / np.linalg.norm(right - left)
    z = np.array([0.0, 0.0, 1.0])
    z = z - (z @ x) * x
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z]), (left + right) / 2


def _in_head_frame(
    basis: Basis, weights: NDArray[np.float64], acting: NDArray[np.float64]
) -> tuple[BaseHead, BaseHead, Eyes]:
    """Shape a coarse head at rest and with an expression, both in the frame of the one at rest.

    The eyes are those at rest: a blink moves lids, not the gaze.
    """
    shaped = basis.shape(weights)
    eyes = find_eyes(basis, shaped)
    rotation, origin = _head_frame(eyes)
    rest = BaseHead(*((part - origin) @ rotation.T for part in shaped))
    worn = rest
    if acting is not weights:
        worn = BaseHead(*((part - origin) @ rotation.T for part in basis.shape(acting)))
    return rest, worn, eyes.moved(rotation, origin)


@lru_cache(maxsize=4)
def position_map(texture_size: int) -> PositionMap:
    """Tell which point of the template each texel of the skin shows; later calls are free.

    Args:
        texture_size: Rows and columns of the skin's texture, >= 64.

    Raises:
        ValueError: The texture is smaller than 64.
    """
    if texture_size < 64:
        raise ValueError(f"texture_size must be >= 64, got {texture_size}")
    surface = load_basis().surface
    drawn, mask = draw_triangles(surface.uv, surface.faces, template().skin, texture_size)
    points = fill_outside(drawn, mask).astype(np.float32)
    for shared in (points, mask):
        shared.setflags(write=False)
    return PositionMap(points, mask)


@lru_cache(maxsize=2)
def _painter(texture_size: int) -> SkinPainter:
    return SkinPainter(*position_map(texture_size), vertices=template().skin)


@lru_cache(maxsize=2)
def _scalp(texture_size: int) -> Scalp:
    return Scalp(position_map(texture_size).points)


def _paint_skin(parameters: Mapping[str, Any], texture_size: int) -> SkinMaps:
    """Paint the skin and, where hair stands, its roots."""
    seed, hair = parameters["seed"], parameters["hair"]
    maps = _painter(texture_size).paint(parameters["appearance"], seed)
    albedo = maps.albedo
    roots = _scalp(texture_size).paint(hair, seed)[..., None]
    albedo += roots * (mean_colour(hair).astype(np.float32) - albedo)
    lining(texture_size).paint(albedo)
    return maps


def _make_eyes(
    eyes: Eyes, margins: NDArray[np.float64], parameters: Mapping[str, Any]
) -> Iterator[Part]:
    """Make both eyeballs, left in the image first, and the lashes before them."""
    ball, rng = unit_ball(), stream(parameters["seed"], "eyes")
    appearance = parameters["appearance"]
    for which, name in enumerate(("left_eye", "right_eye")):
        iris = paint_eye(
            appearance["iris"],
            rng,
            texture_size=EYE_TEXTURE,
            margins=eye_chart(eyes, which, margins[which]),
        )
        yield Part(name, "eye", eyeball_vertices(eyes, which), ball.faces, ball.uv, iris)

    hairs = place_lashes(margins, eyes, appearance["lashes"], rng)
    uv = np.full((len(hairs), 2), 0.5, np.float32)
    albedo = np.full((4, 4, 3), LASH_ALBEDO, np.float32)
    yield Part("lashes", "lash", hairs, lash_faces(), uv, albedo)


def _make_mouth(rest: BaseHead, acting: NDArray[np.float64], parameters: Mapping[str, Any]) -> Part:
    """Make teeth and tongue; the jaw carries the lower ones."""
    column, shade = load_basis().column, stream(parameters["seed"], "mouth").standard_normal()
    units = {unit: float(acting[column[f"unit/{unit}"]]) for unit in JAW_UNITS}
    return build_mouth(rest, units, age=parameters["age"], shade=float(shade))


def sample_head(
    seed: int,
    *,
    texture_size: int = 512,
    population: Population = EVERYBODY,
    expression: str | Expression = "neutral",
) -> Head:
    """Make the person of a seed.

    Args:
        seed: >= 0; see :func:`lrsr.identities.splits.identity_seed`.
        texture_size: Rows and columns of the skin's texture, >= 64.
        population: From whom the person is drawn.
        expression: What the face does, beyond the person's resting face: a name or face units.
            The person is the same: no texture changes, nor do eyeballs and pupils.

    Returns:
        The head: parts "skin", "left_eye", "right_eye" (as seen in the image), "lashes", "hair",
        "mouth". The same arguments give the same bytes; faces, uv and texture sizes are the same
        for all seeds.

    Raises:
        InputError: There is no such expression.
        ValueError: The seed is negative or the texture smaller than 64.
    """
    basis, parameters = load_basis(), sample_parameters(seed, population=population)
    weights = coefficients(
        basis.names,
        parameters["anatomy"],
        masculinity=parameters["masculinity"],
        age=parameters["age"],
        ancestry=parameters["ancestry"],
    )
    weights = rest_lids(basis, weights, template().lids)
    acting = find_expression(expression).act(basis, weights)
    rest, coarse, eyes = _in_head_frame(basis, weights, acting)
    surface = basis.surface
    points = clear_lids(surface.matrix @ coarse.skin, eyes, template().lids)
    points = cavity().hollow(points)
    maps = _paint_skin(parameters, texture_size)
    relief = maps.displacement * cavity().outside
    skin = displace(points, surface.faces, relief).astype(np.float32)
    parts = (
        Part(
            "skin",
            "skin",
            skin,
            surface.faces,
            surface.uv,
            maps.albedo,
            maps.height,
            maps.roughness,
        ),
        *_make_eyes(eyes, lid_margins(points, eyes, template().lids), parameters),
        build_hair(parameters["hair"], skin, seed),
        _make_mouth(rest, acting, parameters),
    )
    return Head(
        identity_id=f"seed-{seed:08d}",
        parts=parts,
        pupils=eyes.pupils,
        landmarks=np.concatenate([eyes.pupils, points[surface.landmarks]]),
        parameters=parameters,
    )
