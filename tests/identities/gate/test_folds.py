import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.template import template
from lrsr.identities.gate.folds import turned_share


def skin() -> NDArray[np.float64]:
    return template().skin.copy()


def cheek(radius_mm: float = 8.0) -> NDArray[np.int64]:
    away = np.linalg.norm(skin() - (40.0, -35.0, 0.0), axis=1)
    return np.flatnonzero(away < radius_mm + 12.0)


def test_the_template_has_no_folds() -> None:
    assert turned_share(skin()) == 0.0


def test_no_folds_come_of_moving_and_gently_bending_a_head() -> None:
    bent = skin() * (0.9, 1.1, 1.05)
    bent[:, 0] += 0.002 * bent[:, 1] ** 2 / 10
    assert turned_share(np.add(bent, (3.0, -50.0, 8.0))) == 0.0


def test_a_cheek_turned_inside_out_is_seen() -> None:
    folded = skin()
    chosen = cheek()
    middle = folded[chosen].mean(axis=0)
    folded[chosen] = middle + (folded[chosen] - middle) * (-1.0, 1.0, 1.0)
    assert turned_share(folded) > 0.002


def test_a_head_seen_from_behind_is_mostly_turned() -> None:
    assert turned_share(skin() * (-1.0, 1.0, -1.0)) > 0.8


def test_eyes_nostrils_and_mouth_are_left_to_others() -> None:
    changed = skin()
    eyes = np.hypot(np.abs(changed[:, 0]) - 31.0, changed[:, 1] + 1.0) < 10.0
    changed[eyes, 2] *= -1.0
    assert turned_share(changed) == 0.0
