"""The measures of scores that are all at hand, which those of streams must agree with."""

from numpy.typing import ArrayLike

from lrsr.evaluation.arrays import check_finite, check_scores, plain_number
from lrsr.evaluation.placements import place
from lrsr.evaluation.rates import _TARGET, OperatingPoint, _Moments, _operating_point, _separation
from lrsr.evaluation.roc import RocCurve, trace_roc_of


def trace_roc(genuine: ArrayLike, impostor: ArrayLike) -> RocCurve:
    return trace_roc_of(place(genuine, impostor))


def fnmr_at_fmr(
    genuine: ArrayLike, impostor: ArrayLike, target_fmr: float, level: float = 0.95
) -> OperatingPoint:
    genuine, impostor = check_scores(genuine, "genuine"), check_scores(impostor, "impostor")
    check_finite(genuine, "genuine")
    check_finite(impostor, "impostor")
    target = plain_number(target_fmr, _TARGET)
    return _operating_point(genuine, impostor, impostor.size, target, level)


def d_prime(genuine: ArrayLike, impostor: ArrayLike) -> float:
    moments = []
    for scores, name in ((genuine, "genuine"), (impostor, "impostor")):
        checked = check_scores(scores, name, at_least=2)
        check_finite(checked, name)
        moments.append(_Moments())
        moments[-1].add(checked)
    return _separation(*moments)
