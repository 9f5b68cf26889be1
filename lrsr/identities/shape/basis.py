"""What is the space of head shapes? ``vertices = neutral + fields x coefficients``, read once.

The file ``assets/head_basis.npz`` is made by :mod:`lrsr.identities.shape.build_basis`; lengths in
it are whole hundredths of a millimetre. Its arrays (K fields, N base vertices, F quads):

=================== ============ ==================================================================
name                shape        content
=================== ============ ==================================================================
provenance          ()           JSON: source, version, sha256 of the inputs, licence
field_names         (K,)         "macro/male/old/max/min", "nose/nose-hump-decr-incr/+", ...
field_counts        (K,)         vertices that each field moves
field_vertices      (nnz,)       which they are, field after field
field_offsets       (nnz, 3)     and where to
vertices            (N, 3)       MakeHuman's base mesh: skin, 2 x 72 eye vertices, lash strips
neutral             (K,)         coefficients of the average adult, the *template*
quads, uv_quads     (F, 4)       corners of the skin, as vertex and as uv indices
uv                  (U, 2)       texture layout, 0..65535, v downwards
region              (F,)         :data:`lrsr.identities.shape.topology.REGIONS`
lash_quads          (L, 4)       strips of the lashes
landmark_vertices   (3,)         nose tip, mouth corners (left, right in the image)
n_skin              ()           how many of the vertices are skin
=================== ============ ==================================================================
"""

import json
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from lrsr.errors import InputError
from lrsr.identities.shape.subdivision import subdivide, triangulate
from lrsr.paths import asset

_UNIT_MM = 0.01
_ROUNDS = 2
_EYE_VERTICES = 72
_SOCKETS = (2, 3)
"""Regions of the left and the right eye socket."""

Points = NDArray[np.float64]


class BaseHead(NamedTuple):
    """The coarse mesh of one head, MakeHuman's axes (x left, y up, z forward), mm.

    Attributes:
        skin: ``(Vs, 3)``.
        eyes: ``(2, 72, 3)``, left and right as seen in the image.
        lashes: ``(Vl, 3)``.
    """

    skin: Points
    eyes: Points
    lashes: Points


@dataclass(frozen=True)
class Surface:
    """The subdivided skin as a renderer wants it: one vertex per pair of position and uv.

    Attributes:
        matrix: Sparse ``(V, Vs)``: render vertices from base vertices; rows sum to 1.
        faces: ``(F, 3)`` int32.
        uv: ``(V, 2)`` float32, v = 0 is the top.
        region: ``(F,)`` uint8, index into ``topology.REGIONS`` of every triangle.
        landmarks: ``(3,)`` render vertices of nose tip and mouth corners.
        twin: ``(V,)``: for each render vertex the first one at the same place.
    """

    matrix: sparse.csr_matrix
    faces: NDArray[np.int32]
    uv: NDArray[np.float32]
    region: NDArray[np.uint8]
    landmarks: NDArray[np.int64]
    twin: NDArray[np.int64]


@dataclass(frozen=True)
class Basis:
    """The shape space; see the table in :mod:`lrsr.identities.shape.basis`."""

    provenance: dict[str, str]
    names: tuple[str, ...]
    fields: sparse.csr_matrix
    vertices: Points
    neutral: Points
    quads: NDArray[np.int64]
    uv_quads: NDArray[np.int64]
    uv: Points
    region: NDArray[np.uint8]
    lash_quads: NDArray[np.int64]
    landmark_vertices: NDArray[np.int64]
    n_skin: int

    @cached_property
    def column(self) -> dict[str, int]:
        """Place of each field among the coefficients."""
        return {name: k for k, name in enumerate(self.names)}

    @cached_property
    def lid_rims(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Base vertices where skin and eye socket meet, left and right in the image."""
        skin = np.unique(self.quads[self.region == 0])
        left, right = (np.intersect1d(skin, self.quads[self.region == k]) for k in _SOCKETS)
        return left, right

    def shape(self, coefficients: Points) -> BaseHead:
        """Return the coarse head of these coefficients.

        Args:
            coefficients: ``(K,)``, in the order of ``names``; 0 everywhere is MakeHuman's base.

        Returns:
            Skin, eyes and lashes; the head is not moved to any frame yet.
        """
        moved = self.vertices + (self.fields @ coefficients).reshape(-1, 3)
        eyes = moved[self.n_skin : self.n_skin + 2 * _EYE_VERTICES].reshape(2, _EYE_VERTICES, 3)
        return BaseHead(moved[: self.n_skin], eyes, moved[self.n_skin + 2 * _EYE_VERTICES :])

    @cached_property
    def surface(self) -> Surface:
        """Two rounds of Catmull-Clark, and the texture layout halved along."""
        smooth = subdivide(self.quads, self.n_skin, _ROUNDS, smooth=True)
        flat = subdivide(self.uv_quads, len(self.uv), _ROUNDS, smooth=False)
        n_flat = flat.matrix.shape[0]
        keys = smooth.quads.ravel() * n_flat + flat.quads.ravel()
        pairs, corner = np.unique(keys, return_inverse=True)
        vertex, texel = pairs // n_flat, pairs % n_flat
        _, first, inverse = np.unique(vertex, return_index=True, return_inverse=True)
        return Surface(
            matrix=sparse.csr_matrix(smooth.matrix[vertex]),
            faces=triangulate(corner.reshape(-1, 4)).astype(np.int32),
            uv=(flat.matrix @ self.uv)[texel].astype(np.float32),
            region=np.repeat(self.region, 2 * 4**_ROUNDS),
            landmarks=np.searchsorted(vertex, self.landmark_vertices),
            twin=first[inverse],
        )


@lru_cache(maxsize=1)
def load_basis() -> Basis:
    """Read the shape space that ships with the package; later calls are free.

    Raises:
        InputError: The file is missing or damaged.
    """
    path = asset("head_basis.npz")
    try:
        with np.load(path, allow_pickle=False) as archive:
            raw = dict(archive)
    except (OSError, ValueError) as error:
        raise InputError(f"{path} cannot be read ({error}): reinstall lrsr") from error
    names = tuple(str(name) for name in raw["field_names"])
    columns = np.repeat(np.arange(len(names)), raw["field_counts"].astype(np.int64))
    rows = 3 * raw["field_vertices"].astype(np.int64)[:, None] + np.arange(3)
    fields = sparse.csr_matrix(
        (
            raw["field_offsets"].ravel().astype(np.float64) * _UNIT_MM,
            (rows.ravel(), np.repeat(columns, 3)),
        ),
        shape=(3 * len(raw["vertices"]), len(names)),
    )
    fields.eliminate_zeros()
    return Basis(
        provenance=json.loads(str(raw["provenance"])),
        names=names,
        fields=fields,
        vertices=raw["vertices"].astype(np.float64) * _UNIT_MM,
        neutral=raw["neutral"].astype(np.float64),
        quads=raw["quads"].astype(np.int64),
        uv_quads=raw["uv_quads"].astype(np.int64),
        uv=raw["uv"].astype(np.float64) / 65535.0,
        region=raw["region"].astype(np.uint8),
        lash_quads=raw["lash_quads"].astype(np.int64),
        landmark_vertices=raw["landmark_vertices"].astype(np.int64),
        n_skin=int(raw["n_skin"]),
    )
