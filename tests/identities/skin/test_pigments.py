import numpy as np
import pytest

from lrsr.identities.skin.pigments import melanin_contrast
from lrsr.identities.skin.tone import tone


def test_fair_skin_shows_all_of_its_unevenness() -> None:
    assert melanin_contrast(0.01) == melanin_contrast(0.03) == 1


@pytest.mark.parametrize("melanin", [0.045, 0.1, 0.22, 0.32])
def test_dark_skin_is_not_patchier_than_fair_skin_by_more_than_three_halves(melanin: float) -> None:
    def patch(mean: float) -> float:
        more = mean * np.exp(0.1 * melanin_contrast(mean))
        return float(np.log(tone(mean, 0.022) / tone(more, 0.022))[1])

    assert patch(melanin) < 2.5 * patch(0.03)
