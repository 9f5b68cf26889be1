"""Tests of lrsr/experiments/report/curves.py: a picture comes out of everything that may go in."""

import base64
from collections.abc import Callable

import cv2
import numpy as np
import pytest
from fakes.measures import trace_roc

from lrsr.evaluation.discard import error_against_discard
from lrsr.evaluation.likelihood import weigh_evidence
from lrsr.evaluation.rates import CmcCurve
from lrsr.evaluation.scores import Scores
from lrsr.experiments.report.curves import draw_det_and_cmc, draw_discard, draw_ece, draw_tippett

PEOPLE = [f"p{k}" for k in range(24)]
MATRIX = np.random.default_rng(0).normal(size=(24, 24)) + 2 * np.eye(24)
EVIDENCE = weigh_evidence(Scores(MATRIX, PEOPLE, PEOPLE), bootstrap=10)
ALONE = weigh_evidence(Scores(MATRIX, PEOPLE, PEOPLE))
CURVE = trace_roc(np.diag(MATRIX), MATRIX[~np.eye(24, dtype=bool)])
SEPARATED = trace_roc([3.0, 4.0], [0.0, 1.0, 2.0])
BOTH = {"a": CURVE, "b": SEPARATED}
RANKS = CmcCurve(np.array([0.5, 0.75, 1.0]), 24, 0)
DISCARD = error_against_discard(np.diag(MATRIX), np.arange(24), 2.0)


@pytest.mark.parametrize(
    ("draw", "width_px"),
    [
        pytest.param(
            lambda: draw_det_and_cmc({"a": CURVE, "b": SEPARATED}, {"a": RANKS}), 1440, id="det"
        ),
        pytest.param(lambda: draw_det_and_cmc({"a": SEPARATED}, {}), 760, id="det-alone"),
        pytest.param(lambda: draw_tippett({"a": EVIDENCE}), 960, id="tippett"),
        pytest.param(lambda: draw_tippett(dict.fromkeys("abcd", ALONE)), 1440, id="tippett-four"),
        pytest.param(lambda: draw_ece(dict.fromkeys("abc", EVIDENCE)), 1440, id="ece"),
        pytest.param(lambda: draw_discard({"norm": {"a": DISCARD}}), 960, id="discard"),
        pytest.param(
            lambda: draw_discard({"norm": {"a": DISCARD, "b": DISCARD}, "ipd": {"a": DISCARD}}),
            1440,
            id="discards",
        ),
    ],
)
def test_a_picture_of_the_pages_width_is_drawn(draw: Callable[[], str], width_px: int) -> None:
    png = base64.b64decode(draw().removeprefix("data:image/png;base64,"))
    image = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    assert image.shape[1] == width_px
    assert image.std() > 5
