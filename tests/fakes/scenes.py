"""Presets by name; scenes, recipes and a renderer of names or values: for tests alone."""

from typing import Any

from lrsr.identities.day.another_day import AnotherDay
from lrsr.identities.face.expression import Expression
from lrsr.identities.head import Head
from lrsr.identities.person import Person
from lrsr.identities.population import EVERYBODY, Population
from lrsr.identities.splits import Split
from lrsr.pictures.recipe import Recipe
from lrsr.presets import preset
from lrsr.rendering.lens import Lens
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.pose import Pose
from lrsr.rendering.radiance import Radiance
from lrsr.rendering.renderer import Renderer
from lrsr.rendering.scene import Film, Quality, Scene
from lrsr.rendering.skin import Skin
from lrsr.rendering.standpoint import Standpoint


def _presets(group: str, *names: str) -> dict[str, Any]:
    return {name: preset(group, name) for name in names}


POSES: dict[str, Pose] = _presets("pose", "frontal", "up", "down", "left")
LIGHTINGS: dict[str, Lighting] = _presets("lighting", "frontal", "above", "below", "side")
ROOMS: dict[str, Lighting] = _presets("lighting", "room_yellow", "room_blue")
LENSES: dict[str, Lens] = _presets("lens", "pinhole", "thin", "single", "double_gauss")
STANDPOINTS: dict[str, Standpoint] = _presets(
    "standpoint", "level", "scface_near", "scface_middle", "scface_far"
)
EXPRESSIONS: dict[str, Expression] = _presets(
    "expression", "neutral", "smile", "grin", "mouth_open", "blink", "squint", "frown", "surprise"
)
DAYS: dict[str, AnotherDay] = _presets(
    "another_day",
    *("none", "hair", "greyer", "stubble", "make_up", "tan", "weight", "years"),
    *("glasses", "cap", "face_mask", "everything"),
)
SKINS: dict[str, Skin] = {
    "reflective": preset("rendering/skin", "reflective"),
    "subsurface": preset("rendering/skin", "jensen_skin1"),
    "subsurface_tone": preset("rendering/skin", "tone"),
    "volumetric": preset("rendering/skin", "volumetric"),
    "volumetric_tone": preset("rendering/skin", "volumetric", fixed="scattering"),
}


def scene(
    pose: str | Pose = "frontal",
    lighting: str | Lighting = "frontal",
    lens: str | Lens = "pinhole",
    standpoint: str | Standpoint = "level",
    expression: str | Expression = "neutral",
    another_day: str | AnotherDay = "none",
) -> Scene:
    """Put before the camera what is named or given."""
    return Scene(
        lighting={**LIGHTINGS, **ROOMS}[lighting] if isinstance(lighting, str) else lighting,
        pose=POSES[pose] if isinstance(pose, str) else pose,
        lens=LENSES[lens] if isinstance(lens, str) else lens,
        standpoint=STANDPOINTS[standpoint] if isinstance(standpoint, str) else standpoint,
        expression=EXPRESSIONS[expression] if isinstance(expression, str) else expression,
        another_day=DAYS[another_day] if isinstance(another_day, str) else another_day,
    )


def recipe(
    index: int = 0,
    split: Split = "test",
    *,
    draw: int = 0,
    population: Population = EVERYBODY,
    ipd_px: float = 8.0,
    scale: int = 1,
    bands: int = 0,
    shift_px: tuple[float, float] = (0.0, 0.0),
    nearer: float = 0.0,
    samples_per_pixel: int = 2048,
    max_depth: int = 5,
    texture_size: int = 1024,
    skin: str | Skin = "reflective",
    seed: int = 0,
    **before: Any,
) -> Recipe:
    """Say what is rendered; what stands before the camera is as :func:`scene` takes it."""
    skin = SKINS[skin] if isinstance(skin, str) else skin
    return Recipe(
        Person(split, index, draw, population),
        scene(**before),
        Film(ipd_px, scale, bands, shift_px, nearer),
        Quality(samples_per_pixel, max_depth, texture_size, skin),
        seed,
    )


class Studio(Renderer):
    """The renderer itself, which can also be told names, sizes and light one by one."""

    def __init__(self, skin: str | Skin = "reflective", *, max_depth: int = 5) -> None:
        super().__init__(SKINS[skin] if isinstance(skin, str) else skin, max_depth=max_depth)

    def render(  # type: ignore[override]  # names for values is what it is for
        self,
        head: Head,
        *,
        ipd_px: float = 8.0,
        scale: int = 1,
        bands: int = 0,
        shift_px: tuple[float, float] = (0.0, 0.0),
        nearer: float = 0.0,
        samples_per_pixel: int = 2048,
        seed: int = 0,
        camera_m: float | None = None,
        **before: Any,
    ) -> Radiance:
        """Render; what stands before the camera is as :func:`scene` takes it."""
        return super().render(
            head,
            scene(**before),
            Film(ipd_px, scale, bands, shift_px, nearer),
            samples_per_pixel=samples_per_pixel,
            seed=seed,
            camera_m=camera_m,
        )
