"""How does light meet skin, eyes, hair and lashes? Numbers for Mitsuba's ``principled`` model.

``base_color`` is the part's albedo texture. The specular number s gives the reflectance at normal
incidence 0.08 s. A part's map of heights turns the normals (``bumpmap``), its map of roughness
replaces the number.
"""

from collections.abc import Mapping
from typing import Any

from lrsr.identities.head import Material

MATERIALS: Mapping[Material, Mapping[str, float]] = {
    # F0 = 0.032 lies between skin's index of 1.4 (0.028, Jensen et al. 2001) and sebum's of 1.47
    # (0.036); Weyrich et al. 2006 measured lobes of width 0.2 to 0.35 on faces, α = roughness² =
    # 0.25 here.
    "skin": {"roughness": 0.5, "specular": 0.4},
    # The tear film: index 1.336, F0 = 0.021, smooth; roughened until its highlight is no firefly.
    "eye": {"roughness": 0.15, "specular": 0.27, "clearcoat": 0.2, "clearcoat_gloss": 0.9},
    # Keratin has the index 1.55, F0 = 0.047; a third of it is taken away for the shade that strands
    # throw on each other, which ribbons lack (estimated). They run along v of the texture.
    "hair": {"roughness": 0.45, "specular": 0.4, "anisotropic": 0.5},
    # Too thin to shine (estimated).
    "lash": {"roughness": 0.9, "specular": 0.0},
    # Acetate, index 1.48, polished; gold, steel or lacquer, brushed (both estimated).
    "plastic": {"roughness": 0.3, "specular": 0.47},
    "metal": {"roughness": 0.35, "metallic": 0.9},
    # Woven cotton and fleece: no mirror, a little fuzz (estimated).
    "cloth": {"roughness": 0.85, "specular": 0.15, "sheen": 0.3},
    # Thin lenses of CR-39 plastic: index 1.5, 4 % reflected by each face.
    "glass": {"specular": 0.5},
}

CLEAR: Material = "glass"
"""What light goes through, without colour: it has no texture."""


def bsdf(
    numbers: Mapping[str, float], textures: Mapping[str, dict[str, Any]]
) -> tuple[dict[str, Any], dict[str, str]]:
    """Describe a two-sided principled BSDF for ``mi.load_dict``, or a thin clear sheet.

    Args:
        numbers: Of the material.
        textures: ``albedo``, none for what is clear; ``roughness`` instead of the number of that
            name; ``height``, mm, of a bump map.

    Returns:
        description: The BSDF.
        keys: The name under which ``mi.traverse`` lists the values of each texture.
    """
    if "albedo" not in textures:
        mirrored = (0.08 * numbers["specular"]) ** 0.5
        return {"type": "thindielectric", "int_ior": (1 + mirrored) / (1 - mirrored)}, {}
    principled = {"type": "principled", **numbers, "base_color": textures["albedo"]}
    inside, keys = "brdf_0", {}
    if "height" in textures:
        keys["height"] = f"{inside}.nested_texture.data"
        inside += ".nested_bsdf"
    keys["albedo"] = f"{inside}.base_color.data"
    if "roughness" in textures:
        principled["roughness"] = textures["roughness"]
        keys["roughness"] = f"{inside}.roughness.data"
    material = principled
    if "height" in textures:
        # Mitsuba's gradient is in texture units and its tangents in mm: heights in mm are to scale.
        material = {"type": "bumpmap", "texture": textures["height"], "bsdf": principled}
    return {"type": "twosided", "material": material}, keys
