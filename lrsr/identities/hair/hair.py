"""How does a head get its hair? One mesh with the same faces for every style and every person.

A shell of combed strands (:mod:`~lrsr.identities.hair.shell`) carries thin ribbons
(:mod:`~lrsr.identities.hair.strands`) that break its outline and its hairline; a shaved head keeps
the mesh, sunk below the skin. The skin under the hair is painted with the hair's colour
(:mod:`~lrsr.identities.hair.scalp`), so that a hairline fades and leaves no dark gap.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.hair.paths import COLUMNS
from lrsr.identities.hair.shell import ROWS, lay_shell, shell_rows, strand_stream
from lrsr.identities.hair.strands import lay_strands, strand_faces, strand_uv
from lrsr.identities.hair.texture import SHELL_COLUMNS, TEXTURE_SHAPE, hair_texture
from lrsr.identities.head import Part


def build_hair(
    parameters: Mapping[str, Any], skin_vertices: NDArray[np.float32], seed: int
) -> Part:
    """Grow one head of hair.

    Args:
        parameters: From :func:`lrsr.identities.hair.choice.sample_hair`.
        skin_vertices: ``(V, 3)`` subdivided skin of the head, mm, in the template's topology.
        seed: Of strands, clumps and ragged edges.

    Returns:
        The part "hair"; its faces, uv and texture size are the same for all heads.
    """
    rng = strand_stream(seed)
    shell = lay_shell(parameters, skin_vertices, rng)
    strands = lay_strands(parameters, shell, rng)
    vertices = np.concatenate([shell.vertices, strands.reshape(-1, 3)])
    texture = hair_texture(parameters, seed)
    return Part("hair", "hair", vertices.astype(np.float32), _hair_faces(), _hair_uv(), texture)


@lru_cache(maxsize=1)
def _hair_faces() -> NDArray[np.int32]:
    """Return the triangles of every head of hair, ``(F, 3)``, shell first; read-only."""
    first = np.arange(COLUMNS - 1)[:, None] * ROWS + np.arange(ROWS - 1)[None, :]
    quads = np.stack([first, first + 1, first + ROWS, first + ROWS + 1], axis=-1).reshape(-1, 4)
    shell = np.concatenate([quads[:, [0, 1, 2]], quads[:, [2, 1, 3]]])
    faces = np.concatenate([shell, strand_faces() + COLUMNS * ROWS]).astype(np.int32)
    faces.setflags(write=False)
    return faces


@lru_cache(maxsize=1)
def _hair_uv() -> NDArray[np.float32]:
    """Return the texture coordinates of every head of hair, ``(V, 2)``, v = 0 root; read-only."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, COLUMNS), shell_rows(), indexing="ij")
    u = u * ((SHELL_COLUMNS - 1.0) / TEXTURE_SHAPE[1])
    shell = np.stack([u, v], axis=-1).reshape(-1, 2).astype(np.float32)
    uv = np.concatenate([shell, strand_uv()])
    uv.setflags(write=False)
    return uv
