"""How is the head held and lit? Poses and lightings, under one roof."""

from lrsr.rendering.colour import LUMINANCE
from lrsr.rendering.environment import GREY, MAP_HEIGHT_PX, environment, lambert_phase
from lrsr.rendering.lighting import LIGHTINGS, ROOMS, Lighting, find_lighting
from lrsr.rendering.lights import Light, Panel
from lrsr.rendering.pose import FOLLOW, PIVOT_MM, POSES, Pose, find_pose

__all__ = [
    "FOLLOW",
    "GREY",
    "LIGHTINGS",
    "LUMINANCE",
    "MAP_HEIGHT_PX",
    "PIVOT_MM",
    "POSES",
    "ROOMS",
    "Light",
    "Lighting",
    "Panel",
    "Pose",
    "environment",
    "find_lighting",
    "find_pose",
    "lambert_phase",
]
