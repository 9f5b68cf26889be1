"""Slow, obvious versions: every pair is counted, in fractions."""

from collections.abc import Sequence
from fractions import Fraction
from itertools import product
from typing import Any

Scores = Any
Fractions = Sequence[Fraction]


def psi(genuine: float, impostor: float) -> Fraction:
    """One where the genuine score wins, one half for a tie (DeLong et al. 1988, eq. 1)."""
    return Fraction(int(genuine > impostor) - int(genuine < impostor) + 1, 2)


def auc(genuine: Scores, impostor: Scores) -> Fraction:
    return Fraction(sum(psi(g, i) for g, i in product(genuine, impostor))) / (
        len(genuine) * len(impostor)
    )


def structural_components(genuine: Scores, impostor: Scores) -> tuple[Fractions, Fractions]:
    """V10 and V01 of DeLong et al.: the mean of psi for each genuine, and each impostor, score."""
    v10 = [sum(psi(g, i) for i in impostor) / len(impostor) for g in genuine]
    v01 = [sum(psi(g, i) for g in genuine) / len(genuine) for i in impostor]
    return v10, v01


def covariance(a: Fractions, b: Fractions) -> Fraction:
    mean_a, mean_b = sum(a) / len(a), sum(b) / len(b)
    return sum((x - mean_a) * (y - mean_b) for x, y in zip(a, b, strict=True)) / (len(a) - 1)


def variance(genuine: Scores, impostor: Scores) -> Fraction:
    v10, v01 = structural_components(genuine, impostor)
    return covariance(v10, v10) / len(genuine) + covariance(v01, v01) / len(impostor)


def variance_of_difference(
    genuine_a: Scores, impostor_a: Scores, genuine_b: Scores, impostor_b: Scores
) -> Fraction:
    """var(a) + var(b) - 2 cov(a, b), as the paper has it."""
    a10, a01 = structural_components(genuine_a, impostor_a)
    b10, b01 = structural_components(genuine_b, impostor_b)
    between = covariance(a10, b10) / len(genuine_a) + covariance(a01, b01) / len(impostor_a)
    return variance(genuine_a, impostor_a) + variance(genuine_b, impostor_b) - 2 * between


def areas_without_each(
    matrix: Scores, probe_ids: list[str], gallery_ids: list[str]
) -> list[Fraction]:
    """Leave each identity out of rows and columns, and measure the area of what remains."""
    identities = sorted(set(probe_ids) | set(gallery_ids))
    areas = []
    for left_out in identities:
        genuine, impostor = [], []
        for row, probe in zip(matrix, probe_ids, strict=True):
            for score, gallery in zip(row, gallery_ids, strict=True):
                if left_out in (probe, gallery) or score != score:
                    continue
                (genuine if probe == gallery else impostor).append(score)
        areas.append(auc(genuine, impostor))
    return areas


def spread_of_jackknife(areas: Fractions) -> Fraction:
    mean = sum(areas) / len(areas)
    return Fraction(len(areas) - 1, len(areas)) * sum((area - mean) ** 2 for area in areas)


def jackknife_variance(matrix: Scores, probe_ids: list[str], gallery_ids: list[str]) -> Fraction:
    return spread_of_jackknife(areas_without_each(matrix, probe_ids, gallery_ids))


def operating_points(genuine: Scores, impostor: Scores) -> list[tuple[Fraction, Fraction]]:
    """Every attainable (fmr, tmr), accepting score >= t for all t that make a difference."""
    thresholds = [float("inf"), *sorted({*genuine, *impostor}, reverse=True)]
    return [
        (
            Fraction(sum(i >= t for i in impostor), len(impostor)),
            Fraction(sum(g >= t for g in genuine), len(genuine)),
        )
        for t in thresholds
    ]
