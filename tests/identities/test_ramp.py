import numpy as np

from lrsr.identities.ramp import smoothstep


def test_smoothstep_rises_from_zero_to_one_through_a_half() -> None:
    value = np.array([-1.0, 0.0, 0.5, 1.0, 2.0])
    assert smoothstep(0.0, 1.0, value).tolist() == [0.0, 0.0, 0.5, 1.0, 1.0]


def test_smoothstep_falls_when_its_limits_are_swapped() -> None:
    value = np.linspace(-1, 3, 9)
    np.testing.assert_allclose(
        smoothstep(2.0, 0.0, value), 1 - smoothstep(0.0, 2.0, value), atol=1e-12
    )


def test_smoothstep_keeps_single_precision() -> None:
    assert smoothstep(-1.0, 2.0, np.ones(3, np.float32)).dtype == np.float32
