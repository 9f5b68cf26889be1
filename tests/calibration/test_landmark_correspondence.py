import numpy as np

from lrsr.calibration.landmark_correspondence import _describe_noise, _nearest_vertices
from lrsr.calibration.landmark_views import plan_views
from lrsr.identities.person import Person
from lrsr.identities.photographs.correspondence import Correspondence

RNG = np.random.default_rng(0)


def test_a_point_is_the_vertex_that_it_follows_whatever_outliers_say() -> None:
    projected = RNG.uniform(0, 100, (40, 30, 2))
    true = RNG.permutation(30)[:12]
    found = projected[:, true] + RNG.normal(0, 1, (40, 12, 2))
    found[:3] += 80
    np.testing.assert_array_equal(_nearest_vertices(found, projected, np.ones(40)), true)


def test_noise_is_told_as_bias_common_parts_and_a_rest() -> None:
    together = np.zeros((5, 2))
    together[:, 0] = 2.0
    common = RNG.standard_normal((4000, 1, 1)) * together
    errors = 0.5 + common + RNG.normal(0, 0.3, (4000, 5, 2))
    bias, components, rest = _describe_noise(errors, 1)
    np.testing.assert_allclose(bias, 0.5, atol=0.12)
    np.testing.assert_allclose(np.abs(components[0]), together, atol=0.1)
    np.testing.assert_allclose(rest, 0.3, rtol=0.08)  # one of ten directions is gone


def test_an_asset_holds_hundredths_of_a_millimetre() -> None:
    noise = Correspondence(np.array([7]), np.array([[0.126, -1]]), np.ones((1, 1, 2)), 0.5, "ab")
    arrays = noise.arrays("a test")
    assert arrays["bias"].tolist() == [[13, -100]]
    assert '"network": "ab"' in str(arrays["provenance"])


def test_views_are_planned_alike_twice_and_begin_frontal() -> None:
    people = [Person("train", 1), Person("train", 2)]
    plan = plan_views(people, 3)
    assert plan == plan_views(people, 3)
    assert [recipe.person.index for recipe in plan] == [1, 1, 1, 2, 2, 2]
    for first in plan[::3]:
        assert abs(first.scene.pose.yaw_deg) <= 3
        assert not first.scene.expression.units
    assert all(recipe.scene.expression.units for recipe in plan[2::3])
