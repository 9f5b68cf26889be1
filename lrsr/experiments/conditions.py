"""Under which conditions is everybody pictured and found? Options one by one, or axes crossed."""

import itertools
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from lrsr.camera import Camera
from lrsr.camera.codec import COMPRESSIONS
from lrsr.camera.preset_file import build_camera, read_preset_file
from lrsr.configuration import (
    as_list,
    as_mapping,
    as_word,
    numbered,
    numbers,
    once,
    require,
    whole_numbers,
    words,
)
from lrsr.paths import user_path
from lrsr.pictures.source import Photographs
from lrsr.presets import value_of
from lrsr.recognition.settings import detector_file
from lrsr.rendering.scene import Film, Scene
from lrsr.rendering.skin import Skin

if TYPE_CHECKING:
    from omegaconf import DictConfig

_OF_EVERY_PROBE = ("lens", "standpoint", "expression", "another_day")
"""What all conditions share, but for those that say otherwise."""

_OF_SCENES = ("pose", "lighting", *_OF_EVERY_PROBE)
_AXES = (*_OF_SCENES, "compression", "camera", "skin", "detector")
"""What a condition can say, and an experiment can go through."""


@dataclass(frozen=True)
class Condition:
    """One way to picture everyone, and to find them: an option of the experiment at one size.

    Attributes:
        option: Number of the option, e.g. 1 to 6 of the paper's Table 2.
        scene: What stands before the camera; None for photographs.
        compression: ``none``, ``small`` or ``heavy``; what the manifest says of photographs.
        ipd_px: Interpupillary distance on the probe, px; None: not known.
        pose: Its name; empty: not known.
        lighting: Its name; empty: not known.
        camera: Takes the probes; None: the experiment's.
        skin: Of everybody, enrolled or not; None: the experiment's.
        detector: What finds the faces, as ``recognition.detector`` names it; None: the
            experiment's.
        varied: What sets it apart, by axis; empty: its number does.
        rival: Option and size of the condition that it is tested against, with the same method;
            None: there is none.

    Raises:
        InputError: A size or a compression does not exist.
    """

    option: int
    scene: Scene | None
    compression: str
    ipd_px: float | None
    pose: str = ""
    lighting: str = ""
    camera: Camera | None = None
    skin: Skin | None = None
    detector: str | None = None
    varied: Mapping[str, str] = field(default_factory=dict)
    rival: tuple[int, float | None] | None = None

    def __post_init__(self) -> None:
        if self.scene is None:
            return
        object.__setattr__(self, "pose", self.scene.pose.name)
        object.__setattr__(self, "lighting", self.scene.lighting.name)
        ipd_px = Film(self.ipd_px or 0).ipd_px
        require(ipd_px >= 4, "ipd_px", f"{ipd_px:g}", "at least 4")
        known = f"one of {', '.join(COMPRESSIONS)}"
        require(self.compression in COMPRESSIONS, "compression", self.compression, known)

    @property
    def setting(self) -> str:
        """What sets it apart in words, e.g. "pose left, lighting above"; empty: its number.

        Photographs, of which nothing varies, are "photographs".
        """
        return self._varied_words() or ("photographs" if self.scene is None else "")

    @property
    def title(self) -> str:
        """What a report calls it."""
        name = "Photographs" if self.scene is None else f"Option {self.option}"
        size = "" if self.ipd_px is None else f", IPD {self.ipd_px:g} px"
        return f"{name}{size}" + (f": {told}" if (told := self._told()) else "")

    def _told(self) -> str:
        known = {"pose": self.pose, "light": self.lighting, "compression": self.compression}
        told = [f"{word} {name}" for word, name in known.items() if name]
        if self.scene is not None:
            worn = (self.scene.expression.name, self.scene.another_day.name)
            told += [name for name in worn if name not in ("neutral", "none")]
        return self._varied_words() or ", ".join(told)

    def _varied_words(self) -> str:
        return ", ".join(f"{axis.replace('_', ' ')} {name}" for axis, name in self.varied.items())

    def describe(self) -> dict[str, Any]:
        """Return all of it in plain values."""
        return {
            **vars(self),
            "scene": None if self.scene is None else self.scene.describe(),
            "camera": None if self.camera is None else self.camera.name,
            "skin": None if self.skin is None else self.skin.name,
            "varied": dict(self.varied),
            "rival": None if self.rival is None else [*self.rival],
        }


class _Option(NamedTuple):
    """What an option says, what sets it apart, and which it is tested against."""

    settings: Mapping[str, Any]
    varied: Mapping[str, str]
    rival: int | None


def read_conditions(config: "DictConfig") -> tuple[Condition, ...]:
    """Read sizes times options: those listed in ``conditions``, or every combination of ``axes``.

    A listed one is tested against itself at the size before.

    Raises:
        InputError: A value is wrong; the message names the setting and the remedy.
    """
    axes = _axes(config)
    listed = numbered(config, "conditions") if "conditions" in config else {}
    wish = "axes or conditions, not both: choose another experiment"
    require(not (axes and listed), "axes", ", ".join(axes), wish)
    table = _crossed(axes, words(config, "against"))
    table |= {number: _Option(settings, {}, None) for number, settings in listed.items()}
    sizes = once(numbers(config, "ipd_px"), "ipd_px")
    require(bool(sizes), "ipd_px", sizes, "at least one size")
    asked = [*table] if config.options is None else whole_numbers(config, "options")
    chosen = once(asked, "options")
    for option in chosen:
        require(option in table, "options", option, f"one of {sorted(table)}")
    made = {  # those that are not chosen are to be right, too
        number: _condition(number, option, sizes[0], config) for number, option in table.items()
    }
    found = []
    for before, ipd in zip([None, *sizes], sizes, strict=False):
        for option in chosen:
            first = option if listed else table[option].rival
            size = before if listed else ipd
            rival = None if first is None or size is None else (first, size)
            found.append(replace(made[option], ipd_px=ipd, rival=rival))
    return tuple(found)


def photographed(config: "DictConfig", photographs: Photographs) -> tuple[Condition, ...]:
    """Return what the manifest says of all photographs, once for each detector.

    Raises:
        InputError: Something else is to vary than the detector.
    """

    def common(name: str, otherwise: Any) -> Any:
        told = {getattr(entry, name) for entry in photographs.entries}
        return told.pop() if len(told) == 1 else otherwise

    names = {name: common(name, "") for name in ("compression", "pose", "lighting")}
    one = Condition(1, None, ipd_px=common("ipd_px", None), **names)
    axes = _axes(config)
    for axis in axes:
        wish = "only a detector: photographs in probes.folder are as they are"
        require(axis == "detector", "axes", axis, wish)
    return tuple(
        replace(
            one,
            option=number,
            varied=varied,
            rival=None if rival is None else (rival, one.ipd_px),
            detector=settings.get("detector"),
        )
        for number, (settings, varied, rival) in _crossed(axes, words(config, "against")).items()
    ) or (one,)


def _axes(config: "DictConfig") -> dict[str, list[str]]:
    """Read what the experiment goes through, and through which values.

    Raises:
        InputError: There is no such axis, or one without values, or with a value twice.
    """
    given = as_mapping(config.axes, "axes")
    axes = {
        str(name): [
            as_word(value, f"axes.{name}") for value in as_list(given[name], f"axes.{name}")
        ]
        for name in given
    }
    for name, values in axes.items():
        require(name in _AXES, "axes", name, f"some of {', '.join(_AXES)}")
        require(len({*values}) == len(values) > 0, f"axes.{name}", values, "values, each once")
    return axes


def _crossed(axes: Mapping[str, list[str]], against: list[str]) -> dict[int, _Option]:
    """Number all combinations; what is tested against has the first values of some axes.

    Raises:
        InputError: ``against`` names no axis, or one with a single value while others vary.
    """
    several = [name for name, values in axes.items() if len(values) > 1]
    for axis in against:
        wish = f"some of the axes, {', '.join(axes)}" if axes else "[], as there are no axes"
        require(axis in axes, "against", axis, wish)
        wish = "two or more, to be compared; or against=[]"
        require(not several or bool({*against} & {*several}), f"axes.{axis}", axes[axis], wish)
    if not axes:
        return {}
    rows = [dict(zip(axes, names, strict=True)) for names in itertools.product(*axes.values())]
    firsts = {axis: axes[axis][0] for axis in against}
    found = {}
    for number, row in enumerate(rows, start=1):
        rival = 1 + rows.index(row | firsts)
        varied = {name: _stem(row[name]) for name in several}
        found[number] = _Option(row, varied, None if rival == number else rival)
    return found


def _condition(number: int, option: _Option, ipd_px: float, config: "DictConfig") -> Condition:
    """Build the values that an option names.

    Raises:
        InputError: There is no such setting or value.
    """
    usual: dict[str, Any] = {"pose": "frontal", "lighting": "frontal", "compression": "none"}
    usual |= {group: config[group] for group in _OF_EVERY_PROBE}
    node = usual | dict(option.settings)
    for name in node:
        wish = f"no such setting; there are {', '.join(_AXES)}"
        require(name in _AXES, f"conditions.{number}", name, wish)
    detector = as_word(node["detector"], "detector") if "detector" in node else None
    detector_file(detector)
    return Condition(
        number,
        Scene(**{group: value_of(group, node[group]) for group in _OF_SCENES}),
        as_word(node["compression"], f"conditions.{number}.compression"),
        ipd_px,
        camera=_camera(node["camera"]) if "camera" in node else None,
        skin=value_of("rendering/skin", node["skin"]) if "skin" in node else None,
        detector=detector,
        varied=option.varied,
    )


def _camera(node: Any) -> Camera:
    """Build a preset by its name, or what a file of the user's describes.

    Raises:
        InputError: There is none, or the file describes something else.
    """
    if isinstance(node, str) and _is_path(node):
        return build_camera(read_preset_file(user_path(node)))
    camera: Camera = value_of("camera", node)
    return camera


def _is_path(word: str) -> bool:
    return os.sep in word or word.lower().endswith((".yaml", ".yml", ".onnx"))


def _stem(word: str) -> str:
    return Path(word).stem if _is_path(word) else word
