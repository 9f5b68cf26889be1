"""How does a head get its hair? One mesh with the same faces for every style and every person.

A shell of combed strands (:mod:`~lrsr.identities.hair.shell`) carries thin ribbons
(:mod:`~lrsr.identities.hair.strands`) that break its outline and its hairline; a shaved head keeps
the mesh, sunk below the skin. The skin under the hair is painted with the hair's colour
(:func:`scalp_mask`, :func:`mean_colour`), so that a hairline fades and leaves no dark gap.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.hair.anchors import load_anchors
from lrsr.identities.hair.choice import colour_parameters, sample_hair
from lrsr.identities.hair.paths import COLUMNS
from lrsr.identities.hair.scalp import Scalp, hairline_polar, scalp_mask
from lrsr.identities.hair.shell import ROWS, lay_shell, shell_rows
from lrsr.identities.hair.strands import lay_strands, strand_faces, strand_uv
from lrsr.identities.hair.styles import STYLES, style_parameters
from lrsr.identities.hair.texture import SHELL_COLUMNS, TEXTURE_SHAPE, hair_texture, mean_colour
from lrsr.identities.head import Part

__all__ = [
    "STYLES",
    "TEXTURE_SHAPE",
    "Scalp",
    "build_hair",
    "colour_parameters",
    "hair_faces",
    "hair_texture",
    "hair_uv",
    "hairline_polar",
    "mean_colour",
    "sample_hair",
    "scalp_mask",
    "style_parameters",
]


def build_hair(
    parameters: Mapping[str, Any], skin_vertices: NDArray[np.float32], seed: int = 0
) -> Part:
    """Grow one head of hair.

    Args:
        parameters: From :func:`sample_hair` or :func:`style_parameters` (with a colour).
        skin_vertices: ``(V, 3)`` subdivided skin of the head, mm, in the template's topology.
        seed: Of strands, clumps and ragged edges.

    Returns:
        The part "hair"; its faces, uv and texture size are the same for all heads.

    Raises:
        InputError: The skin is not of the template's topology.
    """
    rng = np.random.default_rng([seed, 3])
    shell = lay_shell(parameters, load_anchors(), skin_vertices, rng)
    strands = lay_strands(parameters, shell, rng)
    vertices = np.concatenate([shell.points[:, :ROWS].reshape(-1, 3), strands.reshape(-1, 3)])
    return Part(
        name="hair",
        material="hair",
        vertices=vertices.astype(np.float32),
        faces=hair_faces(),
        uv=hair_uv(),
        albedo=hair_texture(parameters, seed),
    )


@lru_cache(maxsize=1)
def hair_faces() -> NDArray[np.int32]:
    """Return the triangles of every head of hair, ``(F, 3)``, shell first; read-only."""
    first = np.arange(COLUMNS - 1)[:, None] * ROWS + np.arange(ROWS - 1)[None, :]
    quads = np.stack([first, first + 1, first + ROWS, first + ROWS + 1], axis=-1).reshape(-1, 4)
    shell = np.concatenate([quads[:, [0, 1, 2]], quads[:, [2, 1, 3]]])
    faces = np.concatenate([shell, strand_faces() + COLUMNS * ROWS]).astype(np.int32)
    faces.setflags(write=False)
    return faces


@lru_cache(maxsize=1)
def hair_uv() -> NDArray[np.float32]:
    """Return the texture coordinates of every head of hair, ``(V, 2)``, v = 0 root; read-only."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, COLUMNS), shell_rows(), indexing="ij")
    u = u * ((SHELL_COLUMNS - 1.0) / TEXTURE_SHAPE[1])
    shell = np.stack([u, v], axis=-1).reshape(-1, 2).astype(np.float32)
    uv = np.concatenate([shell, strand_uv()])
    uv.setflags(write=False)
    return uv
