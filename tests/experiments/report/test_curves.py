"""Tests of lrsr/experiments/report/curves.py: a picture comes out of everything that may go in."""

import base64
from collections.abc import Callable
from xml.etree import ElementTree

import numpy as np
import pytest
from fakes.measures import trace_roc

from lrsr.evaluation.discard import error_against_discard
from lrsr.evaluation.likelihood import weigh_evidence
from lrsr.evaluation.rates import CmcCurve
from lrsr.evaluation.scores import Scores
from lrsr.experiments.report.curves import draw_det_and_cmc, draw_discard, draw_ece, draw_tippett

KIND = "data:image/svg+xml;base64,"
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
    "draw",
    [
        pytest.param(
            lambda: draw_det_and_cmc({"a": CURVE, "b": SEPARATED}, {"a": RANKS}), id="det"
        ),
        pytest.param(lambda: draw_det_and_cmc({"a": SEPARATED}, {}), id="det-alone"),
        pytest.param(lambda: draw_tippett({"a": EVIDENCE}), id="tippett"),
        pytest.param(lambda: draw_tippett(dict.fromkeys("abcd", ALONE)), id="tippett-four"),
        pytest.param(lambda: draw_ece(dict.fromkeys("abc", EVIDENCE)), id="ece"),
        pytest.param(lambda: draw_discard({"norm": {"a": DISCARD}}), id="discard"),
        pytest.param(
            lambda: draw_discard({"norm": {"a": DISCARD, "b": DISCARD}, "ipd": {"a": DISCARD}}),
            id="discards",
        ),
    ],
)
def test_a_picture_of_the_pages_width_is_drawn(draw: Callable[[], str]) -> None:
    picture = ElementTree.fromstring(base64.b64decode(draw().removeprefix(KIND)))
    assert float(picture.attrib["width"].removesuffix("pt")) == pytest.approx(72 * 7.2)
    drawn = [path.get("d", "") for path in picture.iter("{http://www.w3.org/2000/svg}path")]
    assert max(map(len, drawn)) > 100
