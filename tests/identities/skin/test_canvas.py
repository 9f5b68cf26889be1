import numpy as np
import pytest

from lrsr.identities.skin.canvas import Canvas

CANVAS = Canvas(left_mm=-10.0, top_mm=6.0, width_mm=20.0, height_mm=12.0, pixel_mm=0.1)


def test_subjects_left_is_the_sheets_right_and_up_is_up() -> None:
    column, row = CANVAS.to_pixels([5.0, 3.0])
    assert column == pytest.approx(149.5, abs=1e-3)
    assert row == pytest.approx(29.5, abs=1e-3)


def test_a_drawn_dot_is_read_back_where_it_was_drawn() -> None:
    sheet = CANVAS.blank()
    CANVAS.draw_dots(sheet, np.array([[3.0, -2.0]]), [1.0], [200])
    there = CANVAS.to_pixels(np.array([[[3.0, -2.0], [3.0, 2.0]]]))
    assert CANVAS.sample(sheet, there).tolist() == [[200, 0]]


def test_a_dot_covers_its_area() -> None:
    sheet = CANVAS.blank()
    CANVAS.draw_dots(sheet, np.array([[0.0, 0.0]]), [2.0], [255])
    assert sheet.sum() / 255 * 0.01 == pytest.approx(
        np.pi * 4, rel=0.08
    )  # OpenCV adds half a pixel


def test_a_filled_square_covers_its_area() -> None:
    sheet = CANVAS.blank()
    CANVAS.fill_polygon(sheet, np.array([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]))
    assert sheet.sum() / 255 * 0.01 == pytest.approx(16, rel=0.08)  # OpenCV adds half a pixel


def test_strands_are_dealt_to_all_levels() -> None:
    sheet = CANVAS.blank()
    x = np.linspace(-8, 8, 4)
    strands = np.stack([np.stack([x, x], axis=1), np.tile([-5.0, 5.0], (4, 1))], axis=-1)
    CANVAS.draw_strands(sheet, strands, (50, 250))
    columns = [19, 73, 126, 179]
    peaks = [int(sheet[60, column - 2 : column + 3].max()) for column in columns]
    assert peaks[0] < 60
    assert peaks[1] > 160
    assert peaks[2] < 60
    assert peaks[3] > 160


def test_no_strands_leave_the_sheet_blank() -> None:
    sheet = CANVAS.blank()
    CANVAS.draw_strands(sheet, np.zeros((0, 4, 2)), (255,))
    assert not sheet.any()


def test_a_list_of_points_reads_the_same_as_an_image_of_them() -> None:
    rng = np.random.default_rng(0)
    sheet = rng.random(CANVAS.shape).astype(np.float32)
    points = rng.uniform(-12, 12, (40, 50, 2))
    image = CANVAS.sample(sheet, CANVAS.to_pixels(points))
    listed = CANVAS.sample(sheet, CANVAS.to_pixels(points.reshape(-1, 2)))
    np.testing.assert_array_equal(listed, image.ravel())


def test_lists_longer_than_opencv_allows_and_empty_ones_are_read() -> None:
    sheet = np.ones(CANVAS.shape, dtype=np.float32)
    many = CANVAS.to_pixels(np.zeros((70000, 2)))
    assert CANVAS.sample(sheet, many).tolist() == [1.0] * 70000
    assert CANVAS.sample(sheet, many[:0]).shape == (0,)


def test_outside_the_sheet_is_nothing() -> None:
    sheet = np.ones(CANVAS.shape, dtype=np.float32)
    assert CANVAS.sample(sheet, CANVAS.to_pixels(np.array([[50.0, 50.0]])))[0] == 0
