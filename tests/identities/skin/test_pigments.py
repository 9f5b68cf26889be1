import numpy as np
import pytest

from lrsr.identities.skin.pigments import _melanin_contrast
from lrsr.identities.skin.tone import _tone


def test_fair_skin_shows_all_of_its_unevenness() -> None:
    assert _melanin_contrast(0.01) == _melanin_contrast(0.03) == 1


@pytest.mark.parametrize("melanin", [0.045, 0.1, 0.22, 0.32])
def test_dark_skin_is_not_patchier_than_fair_skin_by_more_than_three_halves(melanin: float) -> None:
    def patch(mean: float) -> float:
        more = mean * np.exp(0.1 * _melanin_contrast(mean))
        return float(np.log(_tone(mean, 0.022) / _tone(more, 0.022))[1])

    assert patch(melanin) < 2.5 * patch(0.03)
