"""How does mixed-resolution comparison learn? At once, as many times as there are sizes to try.

What it learns has a closed form, so there is no epoch, no batch and no Lightning; all else is as
with :mod:`lrsr.training.run`: the validation people choose, the run folder says what made it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, ClassVar

from lrsr.configuration import as_list, as_whole, require, settle
from lrsr.errors import InputError
from lrsr.evaluation.delong import measure_auc
from lrsr.files import write_json
from lrsr.onnx import sha256_of
from lrsr.provenance import versions
from lrsr.recognition.mixed_resolution import NAME, Card, CommonSpace, write_space
from lrsr.training.common_space import Sides, judged_by_others, pair, parted, whiten
from lrsr.training.encounters import Encounters, Met
from lrsr.training.resume import forget, refuse_other_run


@dataclass(frozen=True)
class MixedResolution:
    """Which sizes of the common space are tried.

    Attributes:
        components: Principal components of either side; what people do not suffice for is not
            tried.
        dimensions: Directions kept of them; more than there are components are not tried.
        parts: Of the people; each says how far the directions that the others give can be trusted.
        seed: The run's, for the record.

    Raises:
        InputError: A number is none, or there is nothing to try.
    """

    lessons: ClassVar[tuple[str, ...]] = ("encounters",)
    """Options of ``conf/data`` that it learns from."""

    components: Sequence[int]
    dimensions: Sequence[int]
    parts: int = 10
    seed: int = 0

    def __post_init__(self) -> None:
        settle(self, "module")
        for name in ("components", "dimensions"):
            given = as_list(getattr(self, name), f"module.{name}")
            holds = bool(given) and min(as_whole(one, f"module.{name}") for one in given) >= 1
            require(holds, f"module.{name}", given, "whole numbers from 1 on, e.g. [10,20]")
        require(self.parts >= 2, "module.parts", self.parts, "at least 2")
        least, most = min(self.dimensions), max(self.components)
        require(least <= most, "module.dimensions", [*self.dimensions], f"one of {most} at most")

    def spaces(self, met: Met) -> dict[tuple[int, int], CommonSpace]:
        """Learn from people a space of each size, by components and dimension.

        Raises:
            InputError: The people suffice for none.
        """
        most = max(self.components)
        probes, people, gallery = met
        sides = Sides(whiten(probes, most), people, whiten(gallery, most))
        parts = parted(probes, people, gallery, most, self.parts)
        there = min(some.components for some in (sides, *(part.sides for part in parts)))
        sizes = self._sizes(len(gallery), there)
        return {size: judged_by_others(pair(sides, *size), parts, size[0]) for size in sizes}

    def _sizes(self, people: int, there: int) -> list[tuple[int, int]]:
        """Return components and dimensions that can be tried.

        Args:
            people: To learn from.
            there: Components that all parts of them have.

        Raises:
            InputError: There are none.
        """
        sizes = [
            (components, dimension)
            for components, dimension in product(self.components, self.dimensions)
            if dimension <= components < there
        ]
        if not sizes:
            raise InputError(
                f"module.components={list(self.components)}, dimensions={list(self.dimensions)}:"
                f" {people} people suffice for none; give more identities.count"
            )
        return sizes

    def train(
        self,
        data: Encounters,
        *,
        folder: Path,
        resume: bool = True,
        depends_on: Mapping[str, Any],
    ) -> Path:
        """Render what is missing, learn, and write what can be shipped.

        Args:
            data: Whom it learns from, and who chooses the size.
            folder: The run folder; it is there.
            resume: Refuse a folder that holds another run; else begin again.
            depends_on: All that the weights depend on, in plain values; see
                :mod:`lrsr.training.resume`.

        Returns:
            The run folder, with ``model.safetensors`` and ``metrics.json``.

        Raises:
            InputError: The folder holds another run or cannot be written, or the people suffice
                for no size.
        """
        if resume:
            refuse_other_run(folder, depends_on)
        people = len(data.people)
        left_out = -(-people // min(self.parts, people))
        self._sizes(people, people - left_out - 1)  # of so many, their mean taken away, at most
        forget(folder)
        data.prepare_data()
        data.setup()
        spaces = self.spaces(data.training)
        history = [
            {"components": size[0], "dimension": size[1], "val/auc": _auc(space, data.validation)}
            for size, space in spaces.items()
        ]
        best = max(history, key=lambda one: one["val/auc"])
        model = folder / "model.safetensors"
        chosen = spaces[int(best["components"]), int(best["dimension"])]
        write_space(model, chosen, self._card(data))
        told = {"finished": True, "best": best, "history": history, "seed": self.seed}
        told |= {"correlations": chosen.correlations.tolist(), "model_sha256": sha256_of(model)}
        told |= {"settings": dict(depends_on), "versions": versions()}
        write_json(folder / "metrics.json", told)
        return folder

    def _card(self, data: Encounters) -> Card:
        people = len(data.people)
        return Card(
            probe_ipd_px=data.probe_ipd_px,
            gallery_ipd_px=data.gallery_ipd_px,
            people=people,
            scene=data.in_words(),
            source=f"lrsr train recognition={NAME}: {people} rendered people, seed {self.seed}",
        )


def _auc(space: CommonSpace, met: Met) -> float:
    """Return the area under the ROC curve of people who were not learned from."""
    probe_ids, gallery_ids = met.people.tolist(), range(len(met.gallery))
    scores = space.compare(
        space.of_probes(met.probes),
        space.of_gallery(met.gallery),
        [str(one) for one in probe_ids],
        [str(one) for one in gallery_ids],
    )
    return float(measure_auc(scores.genuine(), scores.impostor()))
