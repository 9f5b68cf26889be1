import numpy as np
import pytest

from lrsr.identities.shape.position_map import draw_triangles, fill_outside

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize("size", [1, 4, 64])
def test_a_full_square_shows_its_own_coordinates_at_texel_centres(size: int) -> None:
    drawn, mask = draw_triangles(SQUARE, TWO, SQUARE, size)
    centre = (np.arange(size) + 0.5) / size
    assert mask.all()
    np.testing.assert_allclose(drawn[..., 0], np.tile(centre, (size, 1)), atol=1e-12)
    np.testing.assert_allclose(drawn[..., 1], np.tile(centre[:, None], (1, size)), atol=1e-12)


def test_a_triangle_covers_its_share_of_the_texels() -> None:
    _, mask = draw_triangles(SQUARE, TWO[:1], SQUARE, 200)
    assert mask.mean() == pytest.approx(0.5, abs=0.01)


def test_the_winding_does_not_matter() -> None:
    ahead, _ = draw_triangles(SQUARE, TWO, SQUARE, 16)
    back, _ = draw_triangles(SQUARE, TWO[:, ::-1], SQUARE, 16)
    np.testing.assert_allclose(ahead, back, atol=1e-12)


def test_what_lies_outside_the_texture_and_what_has_no_area_is_left_out() -> None:
    points = np.array([[0.4, 0.4], [2.0, 0.4], [0.4, 2.0], [0.2, 0.2], [0.2, 0.2], [0.3, 0.2]])
    drawn, mask = draw_triangles(points, np.array([[0, 1, 2], [3, 4, 5]]), points, 10)
    assert mask[4:, 4:].sum() > 20
    assert not mask[:4].any()
    assert np.isfinite(drawn).all()


def test_filling_takes_the_nearest_covered_texel() -> None:
    values = np.arange(5.0)[None, :, None]
    mask = np.array([[False, True, False, False, True]])
    assert fill_outside(values, mask)[0, :, 0].tolist() == [1, 1, 1, 4, 4]
