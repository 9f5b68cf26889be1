import json

import numpy as np
import pytest

from lrsr.identities.skin import beard as beards
from lrsr.identities.skin.beard import _BEARD_KINDS, JAW

PLAIN = {
    "kind": "full",
    "density": 1.0,
    "length_mm": 2.0,
    "cheek_line_mm": 0.0,
    "shadow": 0.5,
    "patchiness": 0.0,
    "grey": 1.0,
}

POINTS = {
    "upper lip": (6.0, -57.0, 12.0),
    "lip": (6.0, -68.0, 12.0),
    "chin": (3.0, -100.0, 8.0),
    "jaw": (48.0, -85.0, -25.0),
    "cheek": (48.0, -35.0, -15.0),
    "forehead": (0.0, 50.0, 10.0),
    "nose": (0.0, -40.0, 25.0),
    "neck": (0.0, -145.0, -60.0),
    "back of the head": (20.0, -60.0, -170.0),
}


def _masks(kind: str) -> dict[str, float]:
    position = np.array(list(POINTS.values()))
    lips = np.array([name == "lip" for name in POINTS], dtype=np.float32)
    zones = beards.beard_zones(position, lips)
    mask = beards.beard_mask(PLAIN | {"kind": kind}, zones)
    return dict(zip(POINTS, mask.tolist(), strict=True))


@pytest.mark.parametrize(
    ("kind", "grows"),
    [
        ("none", set()),
        ("stubble", {"upper lip", "chin", "jaw"}),
        ("moustache", {"upper lip"}),
        ("goatee", {"upper lip", "chin"}),
        ("chin", {"chin"}),
        ("full", {"upper lip", "chin", "jaw"}),
    ],
)
def test_each_kind_grows_in_its_places_and_nowhere_else(kind: str, grows: set[str]) -> None:
    masks = _masks(kind)
    assert {name for name, value in masks.items() if value > 0.5} == grows
    assert masks["lip"] == 0
    for bald in ("forehead", "nose", "neck", "back of the head"):
        assert masks[bald] < 0.02, bald


def test_a_higher_cheek_line_grows_more_cheek() -> None:
    position = np.array([[46.0, -52.0, -15.0]])
    zones = beards.beard_zones(position, np.zeros(1, dtype=np.float32))
    high, low = (
        beards.beard_mask(PLAIN | {"cheek_line_mm": line}, zones)[0] for line in (9.0, -12.0)
    )
    assert high > low


def test_both_sides_grow_alike() -> None:
    position = np.random.default_rng(0).uniform((-80, -130, -90), (80, 0, 30), (500, 3))
    bare = np.zeros(500, dtype=np.float32)
    left = beards.beard_zones(position, bare)
    right = beards.beard_zones(position * (-1, 1, 1), bare)
    for name, zone in left.items():
        np.testing.assert_array_equal(zone, right[name], err_msg=name)


def test_the_jaw_unrolls_without_folding() -> None:
    front, left, below = beards.to_jaw(
        np.array([[0.0, -35.0, 10.0], [85.0, -35.0, -75.0], [0.0, -120.0, -75.0]])
    )
    quarter = 85 * np.pi / 2
    np.testing.assert_allclose(front, (0, 0), atol=1e-4)
    np.testing.assert_allclose(left, (quarter, 0), atol=1e-3)
    np.testing.assert_allclose(below[1], -quarter, atol=1e-3)


def test_a_beard_of_density_one_has_9000_strands_that_point_down() -> None:
    strands = beards._beard_strands(PLAIN, np.random.default_rng(0))
    assert strands.shape == (9000, 4, 2)
    assert np.mean(strands[:, -1, 1] < strands[:, 0, 1]) > 0.9


@pytest.mark.parametrize("kind", _BEARD_KINDS)
def test_every_kind_draws_the_same_for_the_same_seed(kind: str) -> None:
    beard = PLAIN | {"kind": kind}
    first, again = (beards.draw_beard(beard, np.random.default_rng(7)) for _ in range(2))
    assert first.shape == JAW.shape
    np.testing.assert_array_equal(first, again)
    assert first.any() == (kind != "none")


def test_longer_beards_cover_more_skin() -> None:
    short, long = (
        beards.draw_beard(PLAIN | {"length_mm": mm}, np.random.default_rng(0)).mean()
        for mm in (1.0, 5.0)
    )
    assert long > 1.3 * short


def test_patches_only_thin_a_beard() -> None:
    rng = np.random.default_rng(0)
    whole = beards.thin_out(PLAIN, rng, (60, 90))
    patchy = beards.thin_out(PLAIN | {"patchiness": 0.8}, rng, (60, 90))
    assert (whole == 1).all()
    assert patchy.min() >= 0
    assert patchy.max() <= 1
    assert patchy.std() > 0.1


def test_where_the_mask_is_soft_only_strong_hairs_grow() -> None:
    opacity = np.array([0.2, 0.9], dtype=np.float32)
    assert beards.feather(opacity, np.ones(2, dtype=np.float32)).tolist() == opacity.tolist()
    soft = np.full(2, 0.36, dtype=np.float32)
    weak, strong = beards.feather(opacity, soft)
    assert weak < 0.01
    assert strong > 0.25
    weaker, stronger = beards.feather(opacity, 2 * soft)
    assert weaker > weak
    assert stronger > strong
    assert not beards.feather(opacity, np.zeros(2, dtype=np.float32)).any()


def test_women_grow_no_beard_and_men_grow_every_kind() -> None:
    rng = np.random.default_rng(0)
    women = [beards.sample_beard(rng, masculinity=0.3, asian=0.0, grey=0.0) for _ in range(100)]
    men = [beards.sample_beard(rng, masculinity=0.95, asian=0.2, grey=0.5) for _ in range(300)]
    assert {beard["kind"] for beard in women} == {"none"}
    assert {beard["shadow"] for beard in women} == {0.0}
    assert {beard["kind"] for beard in men} == set(_BEARD_KINDS)
    assert all(1 <= beard["length_mm"] <= 6 for beard in men)
    assert json.loads(json.dumps(men[0])) == men[0]
