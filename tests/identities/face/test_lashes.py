import json

import numpy as np

from lrsr.identities.face.lashes import _COUNTS, lash_faces, place_lashes, sample_lashes
from lrsr.identities.face.lids import lid_margins
from lrsr.identities.face.template import template

PLAIN = {"length_mm": 8.0, "width_mm": 0.15, "curl": 0.8, "lower": 0.5}


def _place(seed: int = 0, **changes: float) -> np.ndarray:
    average = template()
    margins = lid_margins(average.skin, average.eyes, average.lids)
    return place_lashes(margins, average.eyes, PLAIN | changes, np.random.default_rng(seed))


def test_every_lash_has_three_triangles() -> None:
    faces, hairs = lash_faces(), _place()
    assert len(faces) == 3 * 2 * sum(_COUNTS)
    assert hairs.shape == (faces.max() + 1, 3)
    assert hairs.dtype == np.float32


def test_lashes_point_away_from_the_eye_up_on_the_upper_lid_and_down_on_the_lower() -> None:
    hairs = _place().reshape(2, sum(_COUNTS), 5, 3).astype(float)
    eyes = template().eyes
    distance = np.linalg.norm(hairs - eyes.centres[:, None, None], axis=-1)
    assert (distance[..., 4] > distance[..., :2].max(axis=-1)).all()
    rise = hairs[:, :, 4, 1] - hairs[:, :, 0, 1]
    assert (rise[:, : _COUNTS[0]] > 0).mean() > 0.95
    assert (rise[:, _COUNTS[0] :] < 0).mean() > 0.95


def test_none_is_longer_than_told_and_lower_ones_are_shorter() -> None:
    hairs = _place().reshape(2, sum(_COUNTS), 5, 3)
    length = np.linalg.norm(hairs[..., 4, :] - hairs[..., :2, :].mean(axis=-2), axis=-1)
    upper, lower = length[:, : _COUNTS[0]], length[:, _COUNTS[0] :]
    assert 6.0 < upper.max() < 8.4 + 0.01
    assert lower.max() < 4.3


def test_the_same_seed_sets_the_same_lashes() -> None:
    np.testing.assert_array_equal(_place(3), _place(3))
    assert (_place(3) != _place(4)).any()


def test_womens_lashes_are_longer_and_stronger() -> None:
    rng = np.random.default_rng(0)
    women, men = ([sample_lashes(rng, masculinity=m) for _ in range(200)] for m in (0.1, 0.9))
    for name in ("length_mm", "width_mm"):
        mean = [np.mean([person[name] for person in people]) for people in (women, men)]
        assert mean[0] > 1.2 * mean[1]
    assert json.loads(json.dumps(women[0])) == women[0]
