import numpy as np
import pytest

from lrsr.identities.planes import cross, dot

A, B = np.random.default_rng(0).standard_normal((2, 3, 4, 5)).astype(np.float32)


def test_vector_product_is_numpys() -> None:
    np.testing.assert_allclose(cross(A, B), np.cross(A, B, axis=0), rtol=1e-6)


def test_scalar_product_is_numpys() -> None:
    np.testing.assert_allclose(dot(A, B), np.einsum("kij,kij->ij", A, B), rtol=1e-5, atol=1e-6)


def test_vector_product_stands_upright_on_both() -> None:
    assert dot(cross(A, B), A) == pytest.approx(0.0, abs=1e-5)
    assert dot(cross(A, B), B) == pytest.approx(0.0, abs=1e-5)


def test_single_precision_stays_single() -> None:
    assert (cross(A, B).dtype, dot(A, B).dtype) == (np.float32, np.float32)
