"""How does a head become files that other programs open? glTF 2.0, and OBJ with its textures.

Metres, in the axes of the head frame, which are glTF's: y up, +z to the front. Textures are sRGB.
"""

from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.camera.encoding import encode
from lrsr.files import write_bytes
from lrsr.identities.head import Head, Part

_GLASS_OPACITY = 0.08
_ROUGH = {"eye": 0.15, "glass": 0.0, "plastic": 0.3, "metal": 0.35}
_USUAL_ROUGHNESS = 0.6


def write_meshes(folder: Path, head: Head) -> list[str]:
    """Write ``head.glb``, ``head.obj``, ``head.mtl`` and the albedo of each part.

    Args:
        folder: Where to.
        head: Parts that are folded up are left out; each other one is a mesh of its name.

    Returns:
        Names of the files.

    Raises:
        InputError: The folder cannot be written or the disk is full.
    """
    from trimesh.exchange.obj import export_obj  # half a second

    scene = _make_scene(head)
    text, textures = export_obj(scene, return_texture=True, mtl_name="head.mtl", digits=6)
    files = {"head.glb": scene.export(file_type="glb"), "head.obj": text.encode(), **textures}
    for name, content in files.items():
        write_bytes(folder / name, content, durable=False)  # quickly made again
    return sorted(files)


def _make_scene(head: Head) -> Any:
    """Return a ``trimesh.Scene`` of a head, a geometry and a node for each part, in metres."""
    import trimesh

    scene = trimesh.Scene(metadata={"identity_id": head.identity_id})
    for part in head.parts:
        if np.ptp(part.vertices, axis=0).any():
            scene.add_geometry(_mesh(part), node_name=part.name, geom_name=part.name)
    return scene


def _srgb_texture(albedo: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return linear reflectance ``(H, W, 3)`` as 8-bit sRGB."""
    levels = encode(torch.from_numpy(np.ascontiguousarray(albedo, dtype=np.float32))) * 255
    return np.asarray(levels.round().numpy().astype(np.uint8))


def _mesh(part: Part) -> Any:
    import trimesh
    from PIL import Image
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    is_glass = part.material == "glass"
    material = PBRMaterial(
        name=part.name,
        baseColorTexture=Image.fromarray(_srgb_texture(part.albedo)),
        baseColorFactor=[1.0, 1.0, 1.0, _GLASS_OPACITY if is_glass else 1.0],
        alphaMode="BLEND" if is_glass else "OPAQUE",
        metallicFactor=float(part.material == "metal"),
        roughnessFactor=_ROUGH.get(part.material, _USUAL_ROUGHNESS),
        doubleSided=True,
    )
    below = np.stack([part.uv[:, 0], 1.0 - part.uv[:, 1]], axis=1)  # trimesh's v goes up
    return trimesh.Trimesh(
        part.vertices.astype(np.float64) / 1000,
        part.faces,
        process=False,
        visual=TextureVisuals(uv=below, material=material),
    )
