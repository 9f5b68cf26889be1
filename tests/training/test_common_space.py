"""Tests of lrsr/training/common_space.py."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal
from sklearn.cross_decomposition import CCA

from lrsr.errors import InputError
from lrsr.recognition.mixed_resolution import CommonSpace
from lrsr.training.common_space import (
    _MOST_CORRELATED,
    Sides,
    judged_by_others,
    pair,
    parted,
    whiten,
)

PEOPLE, SMALL, LARGE, SHARED = 6000, 3, 5, 2


def drawn(seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Draw one probe and one enrolled picture of each person, and their joint covariance."""
    rng = np.random.default_rng(seed)
    mix = rng.normal(size=(SMALL + LARGE, SHARED + SMALL + LARGE))
    mix[:SMALL, SHARED + SMALL :] = mix[SMALL:, SHARED : SHARED + SMALL] = 0  # noise of its own
    both = rng.normal(size=(PEOPLE, mix.shape[1])) @ mix.T
    return both[:, :SMALL], both[:, SMALL:], mix @ mix.T


def learned(probes: np.ndarray, gallery: np.ndarray, dimension: int = SMALL) -> CommonSpace:
    people = np.arange(len(gallery))
    return pair(Sides(whiten(probes, LARGE), people, whiten(gallery, LARGE)), LARGE, dimension)


def test_what_is_whitened_has_unit_covariance_the_largest_first() -> None:
    rows = drawn()[1] + 7
    white = whiten(rows, most=4)
    np.testing.assert_allclose(white.rows, (rows - white.mean) @ white.basis, atol=1e-9)
    np.testing.assert_allclose(np.cov(white.rows.T, bias=True), np.eye(4), atol=1e-9)
    assert (np.diff(np.linalg.norm(white.basis, axis=0)) > 0).all()


def test_directions_without_variance_are_none() -> None:
    rows = np.repeat(drawn()[0], 2, axis=1)
    assert whiten(rows, most=6).rows.shape == (PEOPLE, SMALL)


def test_the_ratio_is_that_of_the_true_densities() -> None:
    probes, gallery, covariance = drawn()
    space = learned(probes, gallery)
    x, y = (rows[:100].astype(np.float32) for rows in (probes, gallery))
    people = [str(number) for number in range(100)]
    found = space.compare(space.of_probes(x), space.of_gallery(y), people, people).rows(0, 100)
    apart = covariance.copy()
    apart[:SMALL, SMALL:] = apart[SMALL:, :SMALL] = 0
    together, several = (
        multivariate_normal(np.zeros(SMALL + LARGE), one) for one in (covariance, apart)
    )
    both = np.concatenate(
        [x.repeat(100, axis=0), np.tile(y, (100, 1))], axis=1
    )  # every probe with every enrolled picture
    wanted = (together.logpdf(both) - several.logpdf(both)).reshape(100, 100)
    assert np.abs(found - wanted).mean() < 0.1 * np.abs(wanted - wanted.mean()).mean()
    assert np.corrcoef(found.ravel(), wanted.ravel())[0, 1] > 0.99


def test_correlations_are_canonical() -> None:
    probes, gallery, _ = drawn()
    theirs = CCA(n_components=2, max_iter=2000, tol=1e-10).fit_transform(probes, gallery)
    wanted = [np.corrcoef(a, b)[0, 1] for a, b in zip(theirs[0].T, theirs[1].T, strict=True)]
    np.testing.assert_allclose(learned(probes, gallery, 2).correlations, wanted, atol=1e-4)


def test_what_differs_between_probes_of_one_person_is_discounted() -> None:
    rng = np.random.default_rng(0)
    who, light = rng.normal(size=(500, 1)), rng.normal(size=(2000, 1)) * 10
    people = np.tile(np.arange(500), 4)
    probes = np.hstack([who[people] + 0.1 * rng.normal(size=(2000, 1)), light])
    space = pair(Sides(whiten(probes, 2), people, whiten(np.hstack([who, who**2]), 2)), 2, 1)
    assert space.correlations[0] > 0.98
    assert abs(space.probe_map[1, 0]) < 0.05 * abs(space.probe_map[0, 0])


def test_nothing_is_certain() -> None:
    probes = drawn()[0]
    np.testing.assert_allclose(learned(probes, probes).correlations, _MOST_CORRELATED, rtol=1e-6)


@pytest.mark.parametrize("dimension", [0, 4])
def test_more_directions_than_components_are_refused(dimension: int) -> None:
    probes, gallery, _ = drawn()
    with pytest.raises(InputError, match=f"dimension={dimension}: wanted 1 to 3"):
        learned(probes, gallery, dimension)


def test_everybody_is_left_out_once() -> None:
    gallery = np.random.default_rng(0).normal(size=(7, 4)).astype(np.float32)
    people = np.tile(np.arange(7), 2)
    probes = gallery[people] + 10
    parts = parted(probes, people, gallery, most=2, parts=3)
    left = np.concatenate([part.gallery for part in parts])
    assert sorted(left[:, 0]) == sorted(gallery[people][:, 0])
    for part in parts:
        np.testing.assert_array_equal(part.probes, part.gallery + 10)
        probes_left, rows, gallery_left = part.sides
        assert len(gallery_left.rows) == len(gallery) - len(part.probes) // 2
        assert sorted(rows) == sorted([*range(len(gallery_left.rows))] * 2)
        np.testing.assert_allclose(
            np.abs(probes_left.rows), np.abs(gallery_left.rows[rows]), atol=1e-4
        )
    assert len(parted(probes, people, gallery, most=2, parts=10)) == 7


def test_others_say_how_far_to_trust_what_few_people_gave() -> None:
    rng = np.random.default_rng(0)

    def met(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        probes, gallery = rng.normal(size=(2, count, 8))
        probes[:, 0] *= 5
        gallery[:, 0] = probes[:, 0] + rng.normal(size=count)
        return probes.astype(np.float32), np.arange(count), gallery.astype(np.float32)

    few, many = met(40), met(2000)
    fitted = pair(Sides(whiten(few[0], 8), few[1], whiten(few[2], 8)), 8, 8)
    judged = judged_by_others(fitted, parted(*few, most=8, parts=10), 8)
    assert fitted.correlations[1] > 0.5  # by chance: only the first component is shared
    assert judged.correlations[0] > 0.9
    assert judged.correlations[1:].mean() < 0.15
    people = [str(number) for number in many[1]]
    evidence = []
    for space in (fitted, judged):
        x, y = space.of_probes(many[0]), space.of_gallery(many[2])
        evidence.append(space.compare(x, y, people, people).mated_scores().mean())
    information = -np.log(1 - 25 / 26) / 2  # of the one correlation, 5 / √26
    assert evidence[0] < evidence[1] < information
