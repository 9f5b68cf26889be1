"""How alike are two pictures, and what is that worth? The score, and the ratio it stands for."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from lrsr.configuration import as_mapping, as_word, require, words
from lrsr.errors import ScoreError
from lrsr.evaluation.ratio import Ratio, ratio_of
from lrsr.evaluation.score_files.reading import read_scores
from lrsr.evaluation.score_files.system import Name
from lrsr.evaluation.scores import ScoreSource
from lrsr.experiments.asked import Asked
from lrsr.experiments.basis import choose_basis, scores_file
from lrsr.experiments.portraits import Cut, Portrait, Portraits, look_at
from lrsr.experiments.report.ratios import basis_words, ratio_words
from lrsr.experiments.systems import Comparer, Comparison
from lrsr.files import write_json
from lrsr.paths import path_if_any, user_path
from lrsr.pictures.folder import Entry
from lrsr.presets import build
from lrsr.provenance import versions
from lrsr.recognition.settings import RecognitionSettings
from lrsr.sr.upscaler import Upscaler

if TYPE_CHECKING:
    from omegaconf import DictConfig

_NO_BASIS = (
    "no likelihood ratio: nobody said how known people score on pictures like these. Give such"
    " scores (scores=FILE, as of lrsr score or lrsr eval experiment=own), or simulate the case"
    " (lrsr eval experiment=case)"
)


@dataclass(frozen=True)
class Pair:
    """Two pictures of faces.

    Attributes:
        probe: A file; what it shows is enlarged.
        enrolled: A file.
        cut: What of a large picture is taken.
    """

    probe: Path
    enrolled: Path
    cut: Cut = field(default_factory=Cut)

    def compare(
        self, recognition: RecognitionSettings, methods: Mapping[str, Upscaler]
    ) -> tuple[list[Portrait], list[Comparison]]:
        """Return what was found on both, and the one score of every recogniser and method.

        Raises:
            InputError: A file cannot be read.
        """
        finder = recognition.finder()
        seen = [
            look_at(file.parent, Entry(file.name, str(k)), finder)
            for k, file in enumerate((self.probe, self.enrolled))
        ]
        sides = [
            Portraits(file.parent, [one], self.cut)
            for file, one in zip((self.probe, self.enrolled), seen, strict=True)
        ]
        comparer = Comparer(methods, recognition.engines(), ("own",), finder, progress=False)
        return seen, comparer.compare(*sides)


def score_of(one: Comparison) -> float:
    """Return the score of a comparison of one pair; NaN where a face was not found."""
    return float(one.system.source.rows(0, 1)[0, 0])


@dataclass(frozen=True)
class PairComparison:
    """What is asked about a pair.

    Attributes:
        pair: The pictures.
        method: Name and upscaler.
        recognition: How faces are found and embedded.
        asked: How sure numbers are told.
        scores: Of known people; None: there are none.
        among: Which of them, where there are several conditions or methods.
        out: Where the result goes, too.

    Raises:
        InputError: A value is out of range, or would not be read.
    """

    pair: Pair
    method: Upscaler
    recognition: RecognitionSettings
    asked: Asked
    scores: Path | None = None
    among: Name = field(default_factory=Name)
    out: Path | None = None

    def __post_init__(self) -> None:
        among = self.among
        *others, last = self.recognition.landmarks
        found, given = ([*others, last] == ["own"], "both" if others else last)
        require(found, "recognition.landmarks", given, "own: nobody knows any others")
        for part in ("option", "ipd_px", "method"):
            value = getattr(among, part)
            require(not value or self.scores is not None, part, value, "scores=FILE besides")
        if self.out is not None:
            require(self.out.suffix == ".json", "out", self.out, "a file, such as out=pair.json")

    @classmethod
    def from_config(cls, config: "DictConfig", method: str = "") -> Self:
        """Read a composed configuration of ``lrsr compare``.

        Args:
            config: Of the command.
            method: What files of scores call the upscaler, unless ``config.method`` says.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        files, cut = words(config, "files"), as_mapping(config.cut, "cut")
        require(len(files) == 2, "files", files, "two: lrsr compare PROBE ENROLLED")
        for name in cut:
            require(name in vars(Cut()), "cut", name, f"one of {', '.join(vars(Cut()))}")
        among = {
            key: "" if config[key] is None else as_word(config[key], key)
            for key in ("option", "ipd_px", "method")
        }
        if config.scores is not None:
            among["method"] = among["method"] or method
        probe, enrolled = (user_path(file, "files") for file in files)
        return cls(
            Pair(probe, enrolled, Cut(**cut)),
            build(config.sr, "sr"),
            RecognitionSettings.from_config(config),
            Asked.from_config(config),
            path_if_any(config.scores, "scores"),
            Name(**among),
            path_if_any(config.out, "out"),
        )

    def run(self) -> dict[str, Any]:
        """Compare; write the result where ``out`` says, if anywhere; return it in plain values.

        Raises:
            InputError: A file cannot be read, or the scores do not fit.
        """
        found = {} if self.scores is None else read_scores([scores_file(self.scores)])
        seen, compared = self.pair.compare(self.recognition, {"": self.method})
        told = []
        for one in compared:
            score, basis, ratio, why = score_of(one), None, None, _NO_BASIS
            if math.isnan(score):
                why = "no face was found on both pictures: there is nothing to compare"
            elif self.scores is not None:
                wanted = replace(self.among, landmarks="own", recogniser=one.name.recogniser)
                chosen = choose_basis(scores_file(self.scores), found, wanted)
                basis = chosen.describe()
                try:
                    ratio, why = self._ratio(score, chosen.system.source), ""
                except ScoreError as error:
                    why = f"no likelihood ratio: {error}"
            told.append(
                {
                    "recogniser": one.name.recogniser,
                    "score": None if math.isnan(score) else score,
                    "ratio": None if ratio is None else asdict(ratio),
                    "basis": basis,
                    "why_not": why,
                }
            )
        pictures = []
        for path, shown in zip((self.pair.probe, self.pair.enrolled), seen, strict=True):
            pictures.append({**shown.describe(), "file": str(path)})
            del pictures[-1]["identity_id"]  # nobody knows
        result = {
            "pictures": pictures,
            "method": self.method.describe(),
            "comparisons": told,
            "level": self.asked.level,
            "calibration": self.asked.calibration,
            "bootstrap": self.asked.bootstrap,
            "seed": self.asked.seed,
            "versions": versions(),
        }
        if self.out is not None:
            write_json(self.out, result)
        return result

    def _ratio(self, score: float, source: ScoreSource) -> Ratio:
        asked = self.asked
        return ratio_of(
            score,
            source,
            asked.calibration,
            bootstrap=asked.bootstrap,
            seed=asked.seed,
            level=asked.level,
        )


def lines_of(result: Mapping[str, Any]) -> Iterator[str]:
    """Yield what ``lrsr compare`` prints of a result."""
    for one in result["pictures"]:
        face = "no face found"
        if one["ipd_px"] is not None:
            face = f"face found (detector's score {one['detector_score']:.2f}), "
            face += f"{one['ipd_px']:.1f} px between the pupils"
        yield f"{one['file']}: {one['width_px']} x {one['height_px']} px, {face}"
    for one in result["comparisons"]:
        score = "none" if one["score"] is None else f"{one['score']:.4f} (higher = more alike)"
        yield f"{one['recogniser']}, {result['method']['label']}: score {score}"
        if one["ratio"] is None:
            yield f"  {one['why_not']}"
            continue
        yield f"  likelihood ratio {ratio_words(one['ratio'], result['level'])}"
        named = ", ".join(f"{k} {v}" for k, v in one["basis"].items() if v and k != "file")
        yield f"  based on {basis_words(one['ratio'])} of {one['basis']['file']}" + (
            f" ({named})" if named else ""
        )
        yield "  which holds for pictures that were made as those, and for no others"
