import numpy as np

from lrsr.identities.sheen import ROUGHNESS_LIMITS, SheenPainter, sample_sheen

POINTS = {
    "forehead": (0, 46, 10),
    "nose": (4, -36, 20),
    "chin": (0, -102, 6),
    "neck": (0, -140, -5),
}


def _roughness() -> dict[str, float]:
    position = np.array(list(POINTS.values()), dtype=np.float32)[None]
    painter = SheenPainter(position, np.zeros(position.shape[:2], dtype=np.float32))
    sheen = sample_sheen(np.random.default_rng(0), age=0.3) | {"patchiness": 0.0}
    painted = painter.paint(sheen, np.random.default_rng(0))
    return dict(zip(POINTS, painted[0].tolist(), strict=True))


def test_forehead_and_nose_shine_and_the_chin_does_not() -> None:
    roughness = _roughness()
    assert max(roughness["forehead"], roughness["nose"]) < roughness["neck"] - 0.02
    assert roughness["chin"] > roughness["neck"]


def test_nobody_is_wet_or_chalk() -> None:
    rng = np.random.default_rng(0)
    position = np.array(list(POINTS.values()), dtype=np.float32)[None]
    painter = SheenPainter(position, np.zeros(position.shape[:2], dtype=np.float32))
    people = [painter.paint(sample_sheen(rng, age=k / 99), rng) for k in range(100)]
    low, high = np.float32(ROUGHNESS_LIMITS)
    assert low <= np.min(people) < np.max(people) <= high
    assert np.std([person[0, 0] for person in people]) > 0.03
