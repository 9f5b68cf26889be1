"""How good is a reconstruction, and is the photograph one to be used? The filters of the paper."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from lrsr.configuration import require
from lrsr.identities.photographs.outlines import EYES

Map = NDArray[np.float32]

_IPD_PX = 80.0
_STRIP_PX = (160, 120)
"""Width and height of the upright strip around the eyes; the pupils lie 40 px left and right of
its middle, 50 px below its top."""
_EYES_PX = 50
_BRIDGE = (slice(40, 70), slice(74, 86))
"""Rows and columns between the eyes where a pair of glasses has its bridge."""
_RIMS = ((slice(66, 96), slice(28, 52)), (slice(66, 96), slice(108, 132)))
"""Where it has its lower rims, under the left eye in the image and under the right one."""
_DARKEST = 1 / 16
"""Added to the brightness before its logarithm is taken."""
_EDGE_BLUR_PX = 1.5
_SHARP = 1.4
"""Up to how many px of the photograph one of the strip may span before it is blurred."""


@dataclass(frozen=True)
class Quality:
    """What is measured of a photograph and its reconstruction.

    Attributes:
        ipd_px: Between the pupils, on the photograph.
        score: How sure the landmark network is, [0, 1]; None: it does not say, nor refuse.
        yaw_deg: As :class:`lrsr.rendering.pose.Pose`, as the next two; the fit errs by about 2, 5
            and 1 degree.
        pitch_deg: See above.
        roll_deg: See above.
        distance_m: Of the camera, weakly determined.
        residual_mm: Median distance of the points from where the face has them.
        strangeness: Root mean square of the components of shape, about 1 for drawn people.
        glasses_edge: Of :func:`glasses_edge`; 70 and less without glasses.
        seen: Share of the skin of the face that is seen.
        unevenness: Spread of the logarithm of the skin's brightness that no smooth light explains.
        tint: Logarithms of red and blue of the light that was taken out, over its green.
    """

    ipd_px: float
    score: float | None
    yaw_deg: float
    pitch_deg: float
    roll_deg: float
    distance_m: float
    residual_mm: float
    strangeness: float
    glasses_edge: float
    seen: float
    unevenness: float
    tint: tuple[float, float]


@dataclass(frozen=True)
class Filters:
    """Which photographs are taken; the largest or least value of each measure, None: any.

    Attributes:
        least_ipd_px: Between the pupils.
        least_score: Of the landmark network.
        most_yaw_deg: To either side.
        most_pitch_deg: Up or down.
        most_glasses_edge: Above it somebody wears glasses.
        most_residual_mm: Above it the face does not fit.
        most_strangeness: Above it nobody looks like that.
        least_seen: Below it too much is hidden.

    Raises:
        InputError: A value is negative.
    """

    least_ipd_px: float | None = None
    least_score: float | None = None
    most_yaw_deg: float | None = None
    most_pitch_deg: float | None = None
    most_glasses_edge: float | None = None
    most_residual_mm: float | None = None
    most_strangeness: float | None = None
    least_seen: float | None = None

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            require(value is None or value >= 0, f"filters.{name}", value, "0 or more, or null")

    def refusal(self, quality: Quality) -> tuple[str, str] | None:
        """Return which filter refuses a photograph, and why in words; None: it is taken."""
        yaw, pitch = abs(quality.yaw_deg), abs(quality.pitch_deg)
        edge, strange = quality.glasses_edge, quality.strangeness
        misfit = "no face of ours fits:"
        measures = {
            "ipd_px": ("size", quality.ipd_px, "{:.0f} px between the pupils"),
            "score": ("face", quality.score, "a face by {:.2f} only"),
            "yaw_deg": ("frontal", yaw, "turned aside by {:.0f} degrees"),
            "pitch_deg": ("frontal", pitch, "turned up or down by {:.0f} degrees"),
            "glasses_edge": (
                "glasses",
                edge,
                "glasses: edges of {:.0f} between and under the eyes",
            ),
            "residual_mm": ("fit", quality.residual_mm, misfit + " off by {:.1f} mm"),
            "strangeness": ("fit", strange, misfit + " strange by {:.1f}"),
            "seen": ("fit", quality.seen, "hidden but for a share of {:.2f}"),
        }
        for name, (which, value, words) in measures.items():
            if value is None:
                continue
            least = getattr(self, f"least_{name}", None)
            most = getattr(self, f"most_{name}", None)
            if least is not None and not value >= least:
                return which, f"{words.format(value)}; filters.least_{name} is {least:g}"
            if most is not None and not value <= most:
                return which, f"{words.format(value)}; filters.most_{name} is {most:g}"
        return None


def glasses_edge(srgb: Map, points_px: NDArray[np.float64]) -> float:
    """Return how strong edges are where a pair of glasses has its bridge and its lower rims.

    The strongest horizontal edge between the eyes, and that under the eye where it is weaker:
    wrinkles, shades and noses seldom have both. Sobel, per cent of the brightness.

    Args:
        srgb: ``(H, W, 3)`` float32, [0, 1].
        points_px: ``(N, 2)`` of the landmark network that ships.
    """
    left, right = (points_px[list(corners)].mean(axis=0) for corners in EYES)
    cosine, sine = (right - left) / _IPD_PX
    middle = (left + right) / 2
    turn = np.array([[cosine, -sine], [sine, cosine]])
    start = middle - turn @ [_STRIP_PX[0] / 2, _EYES_PX]
    scale = float(np.hypot(cosine, sine))
    if scale > _SHARP:
        srgb = np.asarray(cv2.GaussianBlur(srgb, (0, 0), 0.45 * scale))
    matrix = np.concatenate([turn, start[:, None]], axis=1)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    strip = cv2.warpAffine(srgb, matrix, _STRIP_PX, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    grey = cv2.cvtColor(np.asarray(strip, np.float32), cv2.COLOR_RGB2GRAY)
    smooth = cv2.GaussianBlur(np.log(np.maximum(grey, 0) + _DARKEST), (0, 0), _EDGE_BLUR_PX)
    edges = np.abs(cv2.Sobel(np.asarray(smooth, np.float32), cv2.CV_32F, 0, 1))
    bridge, *rims = (float(edges[part].mean(axis=1).max()) for part in (_BRIDGE, *_RIMS))
    return 100 * (bridge + min(rims))
