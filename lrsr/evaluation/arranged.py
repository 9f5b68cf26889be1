"""Which scores does a protocol look at, of all probes with a whole gallery?"""

import numpy as np

from lrsr.errors import ScoreError
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.scores import CosineScores, ScoreSource


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


def mean_templates(source: ScoreSource) -> CosineScores:
    """Return cosines with one template a person: the mean of embeddings of length 1, as long.

    A picture without an embedding is left out; a person without any has none.

    Args:
        source: Cosines with every picture of the gallery.

    Raises:
        ScoreError: The scores are others.

    Example:
        >>> faces = np.array([[1.0, 0.0], [0.0, 1.0]])
        >>> both = mean_templates(CosineScores(faces, faces, ["ann", "bob"], ["ann", "ann"]))
        >>> both.gallery.round(3).tolist(), both.gallery_ids
        ([[0.707, 0.707]], ('ann',))
    """
    if not isinstance(source, CosineScores):
        raise ScoreError("templates are means of embeddings, and these scores are none of such")
    people, who = np.unique(source.gallery_ids, return_inverse=True)
    known = np.isfinite(source.gallery).all(axis=1)
    total = np.zeros((people.size, source.gallery.shape[1]))
    np.add.at(total, who[known], source.gallery[known])
    length = np.linalg.norm(total, axis=1, keepdims=True)
    templates = np.divide(total, length, out=np.full_like(total, np.nan), where=length > 0)
    return CosineScores(source.probes, templates, source.probe_ids, people.tolist())
