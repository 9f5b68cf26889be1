"""How far from an average adult are the proportions of a face? Distances, z scores, sigma z.

Landmarks are vertices near points of the template, so they follow the anatomy of any head of its
topology. Lengths are straight, between them, but for the height of the skull, which is upright, as
an anthropometer measures it. Means and standard deviations are those of adults of
both sexes, the latter widened to cover European, Asian and African groups together:

* Farkas, "Anthropometry of the Head and Face", 2nd ed. 1994: North American whites;
* Farkas et al., "International anthropometric study of facial morphology in various ethnic
  groups/races", J. Craniofac. Surg. 16 (2005) 615-646;
* Dodgson, "Variation and extrema of human interpupillary distance", Proc. SPIE 5291 (2004) 36-46;
* for the jaw seen from in front, which palpated gonia do not measure: Lefevre et al., "Telling
  facial metrics", Evol. Hum. Behav. 33 (2012) 273-279 (cheekbone prominence 1.1 to 1.3);
* ears grow 0.22 mm a year: Heathcote, BMJ 311 (1995) 1668;
* faces are a little crooked: Padwa et al., J. Oral Maxillofac. Surg. 55 (1997) 811-816, find 4
  degrees the cant that nine observers of ten notice.

Single measures say whether one feature is out of range, *sigma z* (the standard deviation of all z
scores of a face) whether features that are each possible belong to different faces: Garn et al.,
AJR 144 (1985) 365-369, give 1.2 as the 95th percentile of healthy people and 1.8 to 2 and more for
malformations; Ward et al., Am. J. Med. Genet. 80 (1998) 232-240, use it as the craniofacial
variability index. Both use norms of one ethnic group and many correlated lengths.
"""

import math
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.template import template
from lrsr.identities.shape.basis import load_basis

Points = NDArray[np.float64]
Sex = Literal["female", "male"]

_LIMIT_SD = 3.25
"""One adult in 870 is farther from the mean in a single proportion, one in fifty in any of them."""
SIGMA_Z_LIMIT = 1.5
"""Faces of all ethnic groups judged by wide norms: half way from the healthy to the malformed."""

_MIDLINE = {
    "vertex": (0.0, 114.2, -88.3),
    "nasion": (0.0, 2.5, 8.2),
    "pronasale": (0.0, -41.0, 28.0),
    "subnasale": (0.0, -52.3, 16.5),
    "upper lip": (0.0, -63.6, 19.6),
    "stomion": (0.0, -73.0, 11.3),
    "lower lip": (0.0, -85.1, 13.9),
    "gnathion": (0.0, -115.1, -1.5),
    "glabella": (0.0, 20.0, 11.4),
    "opisthocranion": (0.0, 20.0, -195.0),
}
_SIDES = {
    "alare": (18.1, -44.6, 7.2),
    "zygion": (68.2, -19.0, -41.2),
    "cheek": (66.5, -45.0, -47.0),
    "jaw": (57.5, -79.6, -47.4),
    "eurion": (71.5, 51.0, -78.0),
    "cheilion": (25.0, -73.5, -1.0),
    "exocanthion": (44.6, -2.0, -11.0),
    "endocanthion": (20.3, -3.0, -3.2),
    "inner brow": (17.0, 14.0, 7.0),
    "middle of the brow": (34.0, 18.0, 2.0),
    "superaurale": (75.9, 23.2, -95.9),
    "subaurale": (76.3, -51.0, -92.0),
}
"""Points on the template, mm: in the middle, and on the subject's left with their mirror images."""

_LENGTHS: dict[str, tuple[str, str]] = {
    "face height": ("nasion", "gnathion"),
    "lower face height": ("subnasale", "gnathion"),
    "chin height": ("stomion", "gnathion"),
    "skull height": ("vertex", "nasion"),
    "head length": ("glabella", "opisthocranion"),
    "head width": ("left eurion", "right eurion"),
    "face width": ("left zygion", "right zygion"),
    "cheek width": ("left cheek", "right cheek"),
    "jaw width": ("left jaw", "right jaw"),
    "nose height": ("nasion", "subnasale"),
    "nose width": ("left alare", "right alare"),
    "nose protrusion": ("subnasale", "pronasale"),
    "mouth width": ("left cheilion", "right cheilion"),
    "upper lip height": ("subnasale", "stomion"),
    "upper vermilion": ("upper lip", "stomion"),
    "lower vermilion": ("stomion", "lower lip"),
    "biocular width": ("left exocanthion", "right exocanthion"),
    "intercanthal width": ("left endocanthion", "right endocanthion"),
    "left ear length": ("left superaurale", "left subaurale"),
    "right ear length": ("right superaurale", "right subaurale"),
}
_UPRIGHT = list(_LENGTHS).index("skull height")
"""The length that is taken along the vertical alone."""


class _Proportion(NamedTuple):
    """What adults have.

    Attributes:
        name: Of the proportion.
        part: A length, or "interpupillary distance".
        whole: What it is a share of; "" for millimetres, else percent.
        women: Mean of women.
        men: Mean of men.
        sd: Standard deviation within one sex, all ethnic groups together.
        offset: What the template's landmarks measure beyond the anatomist's.
    """

    name: str
    part: str
    whole: str
    women: float
    men: float
    sd: float
    offset: float = 0.0

    def mean(self, sex: Sex) -> float:
        """Return the mean of a sex, as :func:`proportions` measures."""
        return (self.men if sex == "male" else self.women) + self.offset


_PUPILS = "interpupillary distance"

PROPORTIONS = (
    _Proportion(_PUPILS, _PUPILS, "", 61.7, 64.7, 3.6),
    _Proportion("face height", "face height", "", 111.4, 121.3, 6.5),
    _Proportion("face width", "face width", "", 131.0, 138.0, 7.0),
    _Proportion("face to pupils' width", "face width", _PUPILS, 212.0, 213.0, 12.0),
    _Proportion("facial index", "face height", "face width", 85.0, 88.0, 6.0),
    _Proportion("head index", "head width", "head length", 77.5, 77.0, 5.5, -7.0),
    _Proportion("face to head width", "face width", "head width", 91.0, 92.0, 4.0, 5.0),
    _Proportion("jaw to face width", "jaw width", "face width", 84.0, 86.0, 4.0),
    _Proportion("skull to face height", "skull height", "face height", 97.0, 92.0, 8.0),
    _Proportion("lower to whole face", "lower face height", "face height", 57.7, 58.3, 3.0, -2.0),
    _Proportion("chin to lower face", "chin height", "lower face height", 68.0, 69.0, 3.8),
    _Proportion("nasal index", "nose width", "nose height", 68.0, 69.0, 9.5),
    _Proportion("nose to face width", "nose width", "face width", 25.5, 26.5, 2.8),
    _Proportion("nose to face height", "nose height", "face height", 44.5, 44.0, 3.0, 2.0),
    _Proportion("nose protrusion", "nose protrusion", "", 17.3, 17.8, 2.8),
    _Proportion("mouth to face width", "mouth width", "face width", 38.5, 39.5, 3.6),
    _Proportion("nose to mouth width", "nose width", "mouth width", 68.0, 69.0, 9.0),
    _Proportion("upper lip to lower face", "upper lip height", "lower face height", 31.5, 31, 3.3),
    _Proportion("upper vermilion", "upper vermilion", "", 9.8, 9.8, 2.2, 2.0),
    _Proportion("lower vermilion", "lower vermilion", "", 10.4, 10.4, 2.2, 1.0),
    _Proportion("biocular to face width", "biocular width", "face width", 67.0, 66.5, 3.3),
    _Proportion("intercanthal index", "intercanthal width", "biocular width", 37.0, 37.5, 2.9),
    _Proportion("left ear to face", "left ear length", "face height", 56.0, 55.0, 5.5, 8.0),
    _Proportion("right ear to face", "right ear length", "face height", 56.0, 55.0, 5.5, 8.0),
)
"""Offsets: MakeHuman's ears are long, its head and nasion lie a little elsewhere than a caliper
finds them. Widths between cheekbones and pupils were measured on different people: 212 % is the
quotient of both means, 12 % what their spreads give at a correlation of 0.5, that of a face's
widths."""


@lru_cache(maxsize=1)
def _landmark_vertices() -> dict[str, int]:
    """Find each landmark's vertex on the template's head; the mouth's inside is none of it."""
    surface = load_basis().surface
    head = np.unique(surface.faces[surface.region == 0])
    skin = template().skin[head]
    points = dict(_MIDLINE)
    for name, (x, y, z) in _SIDES.items():
        points |= {f"left {name}": (x, y, z), f"right {name}": (-x, y, z)}
    return {
        name: int(head[np.argmin(np.linalg.norm(skin - point, axis=1))])
        for name, point in points.items()
    }


def measure_lengths(skin: Points, ipd_mm: float) -> dict[str, float]:
    """Measure a head.

    Args:
        skin: ``(V, 3)`` render vertices, mm.
        ipd_mm: Distance of its pupils.

    Returns:
        :data:`_LENGTHS` and the "interpupillary distance", mm.
    """
    vertex = _landmark_vertices()
    ends = np.array([[vertex[a], vertex[b]] for a, b in _LENGTHS.values()])
    between = skin[ends[:, 0]] - skin[ends[:, 1]]
    between[_UPRIGHT] *= (0.0, 1.0, 0.0)
    lengths = np.linalg.norm(between, axis=1)
    return dict(zip(_LENGTHS, lengths.tolist(), strict=True)) | {_PUPILS: ipd_mm}


def measure_crookedness(skin: Points) -> dict[str, float]:
    """Measure how crooked a mouth is.

    Args:
        skin: ``(V, 3)`` render vertices, head frame (the pupils lie on a horizontal), mm.

    Returns:
        The cant of the line between its corners, and how far aside from the nasion their middle
        lies.
    """
    vertex = _landmark_vertices()
    left, right = skin[vertex["left cheilion"]], skin[vertex["right cheilion"]]
    x, y, _ = left - right
    aside = float(left[0] + right[0]) / 2 - float(skin[vertex["nasion"], 0])
    return {
        "crooked: cant of the mouth, degrees": abs(math.degrees(math.atan2(y, x))),
        "crooked: mouth off the middle, mm": abs(aside),
    }


def brow_rise_degrees(skin: Points) -> tuple[float, float]:
    """Return by how much the brows, on the subject's left and right, rise from nose to middle.

    Args:
        skin: ``(V, 3)`` render vertices, head frame, mm.
    """
    vertex = _landmark_vertices()

    def rise(side: str) -> float:
        across, up, _ = (
            skin[vertex[f"{side} middle of the brow"]] - skin[vertex[f"{side} inner brow"]]
        )
        return math.degrees(math.atan2(up, abs(across)))

    return rise("left"), rise("right")


def nose_depth_mm(skin: Points) -> float:
    """Return how far the tip of the nose lies before the widest points of its wings, mm.

    Args:
        skin: ``(V, 3)`` render vertices, head frame, mm.
    """
    vertex = _landmark_vertices()
    wings = (skin[vertex["left alare"], 2] + skin[vertex["right alare"], 2]) / 2
    return float(skin[vertex["pronasale"], 2] - wings)


def proportions(lengths: dict[str, float]) -> dict[str, float]:
    """Turn lengths into :data:`PROPORTIONS`: millimetres, or percent of another length.

    Args:
        lengths: As :func:`measure_lengths` measures them, or published ones, mm.

    Example:
        >>> lengths = dict.fromkeys(_LENGTHS, 50.0) | {"interpupillary distance": 63.0}
        >>> proportions(lengths)["nasal index"]
        100.0
    """
    return {
        p.name: lengths[p.part] * (100.0 / lengths[p.whole] if p.whole else 1.0)
        for p in PROPORTIONS
    }


def z_scores(measured: dict[str, float], sex: Sex) -> dict[str, float]:
    """Tell how many standard deviations each proportion is from the mean of its sex.

    Args:
        measured: As :func:`proportions` gives them.
        sex: "female" or "male".
    """
    return {p.name: (measured[p.name] - p.mean(sex)) / p.sd for p in PROPORTIONS}


def limits(proportion: _Proportion, sex: Sex) -> tuple[float, float]:
    """Return the lowest and the highest value of a human being, as :func:`proportions` measures."""
    middle, reach = proportion.mean(sex), _LIMIT_SD * proportion.sd
    return middle - reach, middle + reach


def sigma_z(scores: dict[str, float]) -> float:
    """Return the standard deviation of a face's z scores.

    Example:
        >>> sigma_z({"a": 1.0, "b": -1.0, "c": 1.0, "d": -1.0})
        1.0
    """
    return float(np.std(list(scores.values())))
