"""How does a command recognise? By the section ``recognition`` of its configuration."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self, cast, get_args

from lrsr.configuration import as_mapping, as_number, as_word, require
from lrsr.paths import path_if_any
from lrsr.recognition.alignment import TEMPLATES, Template
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.enlargement import Enlargement
from lrsr.recognition.engine import FALLBACKS, Engine, Fallback
from lrsr.recognition.finder import Finder
from lrsr.recognition.memory import Memory

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
    """

    model: Path | None = None
    landmarks: tuple[Landmarks, ...] = ("shared",)
    detector: Path | None = None
    enlargement: Enlargement = field(default_factory=Enlargement)
    score_threshold: float | None = None
    alignment: Template | None = None
    fallback: Fallback = "none"

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
        return cls(
            model=path_if_any(given.model, "recognition.model"),
            landmarks=_LANDMARKS if landmarks == "both" else (cast("Landmarks", landmarks),),
            detector=path_if_any(given.detector, "recognition.detector"),
            enlargement=Enlargement(**rule),
            score_threshold=(
                None if threshold is None else as_number(threshold, "recognition.score_threshold")
            ),
            alignment=alignment,
            fallback=given.fallback,
        )

    def finder(self, memory: Memory | None = None) -> Finder | None:
        """Load what finds faces; None where nothing is to be found.

        Args:
            memory: Where detections are kept; default: nowhere.

        Raises:
            InputError: The detector is missing or broken.
        """
        if "own" not in self.landmarks:
            return None
        rule, threshold = self.enlargement, self.score_threshold
        detector = Detector(self.detector, enlargement=rule, score_threshold=threshold)
        return Finder(detector, memory)

    def engine(self, memory: Memory | None = None) -> Engine:
        """Load what recognises.

        Args:
            memory: Where embeddings are kept; default: nowhere.

        Raises:
            InputError: The model is missing or broken.
        """
        return Engine(self.model, template=self.alignment, fallback=self.fallback, memory=memory)


def _choose(name: str, value: object, options: tuple[str, ...]) -> None:
    """Refuse what is not among the options.

    Raises:
        InputError: It is not.
    """
    require(value in options, f"recognition.{name}", value, f"one of {', '.join(options)}")
