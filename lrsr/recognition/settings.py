"""How does a command recognise? By the section ``recognition`` of its configuration."""

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self, cast, get_args

from lrsr.configuration import as_mapping, as_number, as_word, require, words
from lrsr.errors import InputError
from lrsr.onnx import DEVICES
from lrsr.paths import path_if_any
from lrsr.recognition.alignment import TEMPLATES, Template
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.enlargement import Enlargement
from lrsr.recognition.engine import FALLBACKS, Engine, Fallback
from lrsr.recognition.finder import Finder
from lrsr.recognition.memory import Memory
from lrsr.recognition.recognisers import Recogniser, find_recognisers, load_recognisers
from lrsr.recognition.registry import model_file

if TYPE_CHECKING:
    from omegaconf import DictConfig

Landmarks = Literal["shared", "own"]
"""The true ones, scaled, for all methods; or a detector's on each method's own picture."""

_LANDMARKS: tuple[Landmarks, ...] = get_args(Landmarks)


@dataclass(frozen=True)
class RecognitionSettings:
    """How faces are found, aligned and embedded.

    Attributes:
        model: ONNX embedder with its contract beside it; None: the one that ships.
        landmarks: Of which sources, at least one.
        detector: ONNX detector with its contract beside it; None: the one that ships.
        enlargement: How small pictures are enlarged for it.
        score_threshold: Least score of a face; None: the detector's contract says.
        alignment: None: the embedder's contract says.
        fallback: What stands for a face that is not found.
        recognisers: Names; see :func:`lrsr.recognition.recognisers.find_recognisers`.
        device: Where ONNX files run; see :func:`lrsr.onnx.providers_on`.
        weights: Of mixed-resolution comparison, where it is among the recognisers.
    """

    model: Path | None = None
    landmarks: tuple[Landmarks, ...] = ("shared",)
    detector: Path | None = None
    enlargement: Enlargement = field(default_factory=Enlargement)
    score_threshold: float | None = None
    alignment: Template | None = None
    fallback: Fallback = "none"
    recognisers: tuple[str, ...] = ("shipped",)
    device: str = "auto"
    weights: Path | None = None

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read the section.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        given = config.recognition
        landmarks = as_word(given.landmarks, "recognition.landmarks")
        _choose("landmarks", landmarks, (*_LANDMARKS, "both"))
        threshold, alignment = given.score_threshold, given.alignment
        if alignment is not None:
            _choose("alignment", alignment, TEMPLATES)
        _choose("fallback", given.fallback, FALLBACKS)
        rule = as_mapping(given.enlargement, "recognition.enlargement")
        for name in rule:
            _choose("enlargement", name, tuple(vars(Enlargement())))
        model = path_if_any(given.model, "recognition.model")
        weights = path_if_any(given.weights, "recognition.weights")
        recognisers = tuple(words(given, "recognisers"))
        find_recognisers(recognisers, model, weights)
        device = as_word(given.device, "recognition.device")
        _choose("device", device, DEVICES)
        return cls(
            model=model,
            landmarks=_LANDMARKS if landmarks == "both" else (cast("Landmarks", landmarks),),
            detector=(
                None
                if given.detector is None
                else detector_file(as_word(given.detector, "recognition.detector"))
            ),
            enlargement=Enlargement(**rule),
            score_threshold=(
                None if threshold is None else as_number(threshold, "recognition.score_threshold")
            ),
            alignment=alignment,
            fallback=given.fallback,
            recognisers=recognisers,
            device=device,
            weights=weights,
        )

    def finder(self, memory: Memory | None = None, detector: str | None = None) -> Finder | None:
        """Load what finds faces; None where nothing is to be found.

        Args:
            memory: Where detections are kept; default: nowhere.
            detector: Its name, in place of the settings' own.

        Raises:
            InputError: The detector is missing or broken.
        """
        if "own" not in self.landmarks:
            return None
        found = Detector(
            self.detector if detector is None else detector_file(detector),
            enlargement=self.enlargement,
            score_threshold=self.score_threshold,
            device=self.device,
        )
        return Finder(found, memory)

    def engines(self, memory: Memory | None = None) -> dict[str, Recogniser]:
        """Load what recognises, by what a report calls it.

        Args:
            memory: Where embeddings are kept; default: nowhere.

        Raises:
            InputError: The model is missing or broken.
        """
        load = partial(
            Engine,
            template=self.alignment,
            fallback=self.fallback,
            memory=memory,
            device=self.device,
        )
        names = find_recognisers(self.recognisers, self.model, self.weights)
        found = load_recognisers(names, load, memory)
        if self.fallback != "none" and not all(isinstance(one, Engine) for one in found.values()):
            raise InputError(
                f"recognition.fallback={self.fallback}: only ONNX files can take a whole picture"
                " for a face; leave it, or name only such recognisers"
            )
        return found


def detector_file(name: str | None) -> Path | None:
    """Return the file of a detector by its name; None, as for "shipped": the one that ships.

    Raises:
        InputError: There is none of this name, or it is no detector.
    """
    return None if name is None or name == "shipped" else model_file(name, "detector")


def _choose(name: str, value: object, options: tuple[str, ...]) -> None:
    """Refuse what is not among the options.

    Raises:
        InputError: It is not.
    """
    require(value in options, f"recognition.{name}", value, f"one of {', '.join(options)}")
