"""Which person does a seed stand for? A head of the CC0 shape space, with skin, eyes and hair.

``sample_head(seed)`` is the whole recipe: plain numbers are drawn once (:func:`sample_parameters`),
shape, skin, brows, beard, eyes and hair are made from them, so they agree with each other. Every
trait has a random stream of its own, so a change to one of them leaves the others as they were.
A face or a head of hair that no adult has is drawn again (:mod:`lrsr.identities.gate.gate`) before
anything costly is made of it. All people are adults.
"""

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.random import Generator, SeedSequence
from numpy.typing import NDArray

from lrsr.configuration import as_whole
from lrsr.identities.appearance import SkinMaps, SkinPainter, sample_appearance
from lrsr.identities.day.another_day import SAME_DAY, AnotherDay
from lrsr.identities.day.changes import change_person
from lrsr.identities.day.worn import dress
from lrsr.identities.face.expression import NEUTRAL, Expression
from lrsr.identities.face.eyes import Eyes, eye_chart, eyeball_vertices, unit_ball
from lrsr.identities.face.iris import paint_eye
from lrsr.identities.face.lashes import lash_faces, place_lashes
from lrsr.identities.face.lids import clear_lids, lid_margins
from lrsr.identities.face.mouth import JAW_UNITS, build_mouth, cavity, lining
from lrsr.identities.face.resting import RestingFace, act, rest_face
from lrsr.identities.face.template import template
from lrsr.identities.gate.gate import draw_plausible, record
from lrsr.identities.gate.plausibility import check_face, check_hair
from lrsr.identities.hair.choice import sample_hair
from lrsr.identities.hair.hair import build_hair
from lrsr.identities.hair.scalp import Scalp
from lrsr.identities.hair.texture import mean_colour
from lrsr.identities.head import Head, Part
from lrsr.identities.population import (
    ANCESTRIES,
    EVERYBODY,
    OLDEST_YEARS,
    YOUNGEST_YEARS,
    Population,
)
from lrsr.identities.shape.anatomy import Anatomy, coefficients, sample_anatomy
from lrsr.identities.shape.basis import BaseHead, load_basis
from lrsr.identities.shape.position_map import PositionMap, draw_triangles, fill_outside
from lrsr.identities.shape.proportions import load_gauge
from lrsr.identities.skin.features import cover
from lrsr.identities.skin.relief import displace

RECIPE_VERSION = "13"
"""Changes whenever the same seed would give other pixels."""

_STREAMS = ("person", "anatomy", "appearance", "hair", "eyes", "mouth")
"""One independent source of chance for each; append, never reorder."""

_LASH_ALBEDO = 0.015

_PLAIN_SEED = 500_007
"""Somebody young, with even skin and without a beard."""


def _stream(seed: int, name: str, attempt: int = 0) -> Generator:
    """Return the random generator of one trait of one person.

    Args:
        seed: The person, >= 0.
        name: One of :data:`_STREAMS`.
        attempt: How often the trait was drawn before, >= 0.

    Raises:
        ValueError: The seed is negative or the name unknown.
    """
    if seed < 0:
        raise ValueError(f"seed must be >= 0, got {seed}")
    key = (attempt,) if attempt else ()
    return np.random.default_rng(SeedSequence([seed, _STREAMS.index(name)], spawn_key=key))


def _sample_masculinity(rng: Generator, population: Population) -> float:
    """Draw a woman (0.01 to 0.12) or a man (0.75 to 0.98), evenly where both are in it.

    MakeHuman's women are less unlike its men than people are: nearer to the middle than this,
    a network that was trained on real faces takes them for men.
    """
    share = float(rng.beta(2.0, 1.2))
    male = population.male(bool(rng.random() < 0.5))
    return 0.75 + 0.23 * share if male else 0.12 - 0.11 * share


def sample_parameters(seed: int, *, population: Population = EVERYBODY) -> dict[str, Any]:
    """Draw everything about a person, as plain numbers and names.

    Args:
        seed: >= 0.
        population: From whom.

    Returns:
        JSON-serialisable: ``sex``, ``masculinity`` (0..1), ``age`` (0..1), ``age_years`` (25..75),
        ``ancestry`` (shares of :data:`lrsr.identities.population.ANCESTRIES`), ``anatomy`` (see
        :class:`lrsr.identities.shape.anatomy.Anatomy`), what skin, eyes and hair need, and
        ``gate``, what was drawn again and why (see :func:`lrsr.identities.gate.gate.record`).

    Raises:
        InputError: The seed is no whole number.
        ValueError: It is negative.
    """
    return _draw_person(as_whole(seed, "seed"), population)[0]


def _draw_person(seed: int, population: Population) -> tuple[dict[str, Any], RestingFace]:
    """Draw a person and the face at rest; the gate judges neither texture nor expression."""
    who = _draw_traits(seed, population)
    iris = who["appearance"]["iris"]["half_angle_rad"]
    (numbers, face), failures = draw_plausible(
        lambda attempt: _draw_face(who, attempt),
        lambda drawn: check_face(drawn[1].skin, drawn[1].eyes, who["sex"], iris),
    )
    skin = face.skin.astype(np.float32)
    hair, misfits = draw_plausible(
        lambda attempt: _draw_hair(who, attempt), lambda drawn: check_hair(drawn, skin, seed)
    )
    gate = record([*failures, *misfits])
    return {**who, "anatomy": numbers, "hair": hair, "gate": gate}, face


def _draw_traits(seed: int, population: Population) -> dict[str, Any]:
    """Draw what is never drawn again: sex, age, ancestry, and all colours."""
    rng = _stream(seed, "person")
    masculinity = _sample_masculinity(rng, population)
    age = population.age(float(rng.beta(1.1, 1.5)))
    shares = population.shares(rng.dirichlet([0.25] * len(ANCESTRIES)))
    return {
        "seed": seed,
        "recipe": RECIPE_VERSION,
        "sex": "male" if masculinity >= 0.5 else "female",
        "masculinity": masculinity,
        "age": age,
        "age_years": YOUNGEST_YEARS + (OLDEST_YEARS - YOUNGEST_YEARS) * age,
        "ancestry": {race: float(share) for race, share in zip(ANCESTRIES, shares, strict=True)},
        "appearance": sample_appearance(
            _stream(seed, "appearance"), masculinity=masculinity, age=age, ancestry=shares
        ),
    }


def _another_day(
    parameters: dict[str, Any], face: RestingFace, day: AnotherDay
) -> tuple[dict[str, Any], RestingFace]:
    """Let a day come over a person."""

    def appearance_at(age: float) -> Mapping[str, Any]:
        shares = [parameters["ancestry"][race] for race in ANCESTRIES]
        masculinity = parameters["masculinity"]
        rng = _stream(parameters["seed"], "appearance")
        return sample_appearance(rng, masculinity=masculinity, age=age, ancestry=shares)

    return change_person(parameters, face, day, appearance_at)


def _draw_face(who: Mapping[str, Any], attempt: int) -> tuple[Anatomy, RestingFace]:
    names, rng = load_basis().names, _stream(who["seed"], "anatomy", attempt)
    traits = {trait: who[trait] for trait in ("masculinity", "age", "ancestry")}
    anatomy = sample_anatomy(names, load_gauge(), rng, **traits)
    return anatomy, rest_face(coefficients(names, anatomy, **traits))


def _draw_hair(who: Mapping[str, Any], attempt: int) -> dict[str, Any]:
    rng, colour = _stream(who["seed"], "hair", attempt), who["appearance"]["hair_colour"]
    return sample_hair(rng, who["masculinity"], who["age"], who["ancestry"], colour)


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
def _painters(texture_size: int) -> tuple[SkinPainter, Scalp]:
    chart = position_map(texture_size)
    return SkinPainter(chart, template().skin), Scalp(chart.points)


def _paint_skin(parameters: Mapping[str, Any], texture_size: int) -> SkinMaps:
    """Paint the skin and, where hair stands, its roots."""
    seed, hair = parameters["seed"], parameters["hair"]
    skin, scalp = _painters(texture_size)
    maps = skin.paint(parameters["appearance"], seed)
    cover(maps.albedo, mean_colour(hair), *scalp.roots(hair, seed))
    lining(texture_size).paint(maps.albedo)
    return maps


def paint_plain_skin(texture_size: int) -> SkinMaps:
    """Paint an adult's skin without brows, beard, make-up, marks and lines; pores remain.

    Args:
        texture_size: Rows and columns, >= 64.
    """
    drawn = _draw_traits(_PLAIN_SEED, EVERYBODY)["appearance"]
    none: dict[str, tuple[str, ...]] = {
        "marks": ("moles", "freckles", "age_spots", "capillaries"),
        "make_up": ("lipstick", "eyeliner", "eyeshadow", "blush"),
        "lines": ("nasolabial", "chin", "lid_crease"),
        "brows": ("density",),
    }
    plain: Any = dict(drawn)
    for name, parts in none.items():
        plain[name] = {**plain[name], **dict.fromkeys(parts, 0)}
    maps = _painters(texture_size)[0].paint(plain, _PLAIN_SEED)
    lining(texture_size).paint(maps.albedo)
    return maps


def _make_eyes(
    eyes: Eyes, margins: NDArray[np.float64], parameters: Mapping[str, Any]
) -> Iterator[Part]:
    """Make both eyeballs, left in the image first, and the lashes before them."""
    ball, rng = unit_ball(), _stream(parameters["seed"], "eyes")
    appearance = parameters["appearance"]
    for which, name in enumerate(("left_eye", "right_eye")):
        iris = paint_eye(appearance["iris"], rng, eye_chart(eyes, which, margins[which]))
        yield Part(name, "eye", eyeball_vertices(eyes, which), ball.faces, ball.uv, iris)

    hairs = place_lashes(margins, eyes, appearance["lashes"], rng)
    uv = np.full((len(hairs), 2), 0.5, np.float32)
    albedo = np.full((4, 4, 3), _LASH_ALBEDO, np.float32)
    yield Part("lashes", "lash", hairs, lash_faces(), uv, albedo)


def _make_mouth(rest: BaseHead, acting: NDArray[np.float64], parameters: Mapping[str, Any]) -> Part:
    """Make teeth and tongue; the jaw carries the lower ones."""
    column, shade = load_basis().column, _stream(parameters["seed"], "mouth").standard_normal()
    units = {unit: float(acting[column[f"unit/{unit}"]]) for unit in JAW_UNITS}
    return build_mouth(rest, units, age=parameters["age"], shade=float(shade))


def sample_head(
    seed: int,
    *,
    texture_size: int = 1024,
    population: Population = EVERYBODY,
    expression: Expression = NEUTRAL,
    another_day: AnotherDay = SAME_DAY,
) -> Head:
    """Make the person of a seed.

    Args:
        seed: >= 0; see :func:`lrsr.identities.splits.identity_seed`.
        texture_size: Rows and columns of the skin's texture, >= 64.
        population: From whom the person is drawn.
        expression: What the face does, beyond the person's resting face.
            The person is the same: no texture changes, nor do eyeballs and pupils.
        another_day: What has changed since the person was enrolled, and what is worn.

    Returns:
        The head: parts "skin", "left_eye", "right_eye" (as seen in the image), "lashes", "hair",
        "mouth"; on another day also "glasses", "lenses", "cap", "face_mask", where it
        may bring them. The same arguments give the same bytes; faces, uv and texture sizes are
        the same for all seeds.

    Raises:
        InputError: A number is no whole number.
        ValueError: The seed is negative or the texture smaller than 64.
    """
    seed, texture_size = as_whole(seed, "seed"), as_whole(texture_size, "texture_size")
    parameters, face = _draw_person(seed, population)
    if not another_day.is_same:
        parameters, face = _another_day(parameters, face, another_day)
    acting, points = act(face, expression)
    eyes, surface = face.eyes, load_basis().surface
    points = cavity().hollow(points)
    albedo, height, roughness, displacement = _paint_skin(parameters, texture_size)
    relief = displace(points, surface.faces, displacement * cavity().outside)
    skin = clear_lids(relief, eyes, template().lids).astype(np.float32)
    parts: tuple[Part, ...] = (
        Part("skin", "skin", skin, surface.faces, surface.uv, albedo, height, roughness),
        *_make_eyes(eyes, lid_margins(points, eyes, template().lids), parameters),
        build_hair(parameters["hair"], skin, seed),
        _make_mouth(face.shape, acting, parameters),
    )
    landmarks = np.concatenate([eyes.pupils, points[surface.landmarks]])
    parts, worn = dress(parts, eyes.pupils, landmarks, another_day, seed)
    if not another_day.is_same:
        parameters["another_day"] |= worn
    return Head(
        identity_id=f"seed-{seed:08d}",
        parts=parts,
        pupils=eyes.pupils,
        landmarks=landmarks,
        parameters=parameters,
    )
