"""Which scores does a protocol look at, of all probes with a whole gallery?"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.scores import CosineScores, ScoreSource


@dataclass(frozen=True)
class Templates:
    """Which pictures are compared as one.

    Attributes:
        of: Name of each picture's template.
        media: Name of each picture's medium, such as a video: what a template has of one medium
            counts as much as one picture, its mean; None: every picture counts alike.
    """

    of: Sequence[str]
    media: Sequence[str] | None = None

    @property
    def names(self) -> Sequence[str]:
        """Of the templates, sorted."""
        return sorted({*self.of})

    def fuse(self, embeddings: Array, people: Sequence[str]) -> tuple[Array, Sequence[str]]:
        """Return an embedding of length 1 for each template, ``(T, D)``, and whom each shows.

        Args:
            embeddings: ``(N, D)`` of the pictures, NaN where there is none.
            people: Whom each picture shows.

        Raises:
            ScoreError: A template shows two people.
        """
        _, first, number = np.unique(self.of, return_index=True, return_inverse=True)
        who = np.array(people)
        if (mixed := who != who[first][number]).any():
            raise ScoreError(f"template {self.of[int(np.argmax(mixed))]} shows two people")
        known = np.flatnonzero(np.isfinite(embeddings).all(axis=1))
        weight = np.ones(known.size)
        if self.media is not None:
            media = np.array([*zip(self.of, self.media, strict=True)])[known]
            _, medium, count = np.unique(media, axis=0, return_inverse=True, return_counts=True)
            weight /= count[medium.ravel()]
        total = np.zeros((first.size, embeddings.shape[1]))
        np.add.at(total, number[known], weight[:, None] * embeddings[known])
        length = np.linalg.norm(total, axis=1, keepdims=True)
        fused = np.divide(total, length, out=np.full_like(total, np.nan), where=length > 0)
        return fused, who[first].tolist()


def diagonal(source: ScoreSource) -> PairScores:
    """Return the scores of row and column 0, of row and column 1, and so on, as listed pairs.

    Example:
        >>> from lrsr.evaluation.scores import Scores
        >>> matrix = np.array([[0.9, 0.5], [0.5, 0.1]])
        >>> diagonal(Scores(matrix, ["ann", "ann"], ["ann", "bob"])).impostor().tolist()
        [0.1]
    """
    parts = [
        tile.scores[np.arange(len(tile.scores)), np.arange(tile.rows.start, tile.rows.stop)]
        for tile in source.tiles()
    ]
    return PairScores(np.concatenate(parts), source.probe_ids, source.gallery_ids)


def mean_templates(
    source: ScoreSource, *, probes: Templates | None = None, gallery: Templates | None = None
) -> CosineScores:
    """Return cosines of templates: means of embeddings of length 1, as long.

    A picture without an embedding is left out; a template without any has none.

    Args:
        source: Cosines of every probe with every picture of the gallery.
        probes: Which probes are one; None: each is by itself.
        gallery: Which pictures of the gallery are one, likewise.

    Raises:
        ScoreError: The scores are others, or a template shows two people.

    Example:
        >>> faces = np.array([[1.0, 0.0], [0.0, 1.0]])
        >>> scores = CosineScores(faces, faces, ["ann", "bob"], ["ann", "ann"])
        >>> mean_templates(scores, gallery=Templates(["t1", "t1"])).gallery.round(3).tolist()
        [[0.707, 0.707]]
    """
    if not isinstance(source, CosineScores):
        raise ScoreError("templates are means of embeddings, and these scores are none of such")
    rows, columns = (source.probes, source.probe_ids), (source.gallery, source.gallery_ids)
    if probes is not None:
        rows = probes.fuse(*rows)
    if gallery is not None:
        columns = gallery.fuse(*columns)
    return CosineScores(rows[0], columns[0], rows[1], columns[1])
