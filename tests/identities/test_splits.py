import pytest

from lrsr.identities.splits import LARGEST_INDEX, SPLITS, Split, identity_seed


@pytest.mark.parametrize(
    ("split", "seed"), [("train", 30), ("validation", 31), ("test", 32)], ids=SPLITS
)
def test_the_tenth_identity_of_each_split(split: Split, seed: int) -> None:
    assert identity_seed(split, 10) == seed


def test_no_seed_belongs_to_two_splits_and_none_is_left_out() -> None:
    seeds = [identity_seed(split, index) for split in SPLITS for index in range(100)]
    assert sorted(seeds) == list(range(300))


@pytest.mark.parametrize("split", SPLITS)
def test_the_split_of_a_seed_is_the_one_it_was_made_for(split: Split) -> None:
    assert {SPLITS[identity_seed(split, index) % 3] for index in range(50)} == {split}


def test_whoever_is_redrawn_stays_in_the_split_and_is_nobody_else() -> None:
    people = [
        (split, index, draw)
        for split in SPLITS
        for index in (0, 7, LARGEST_INDEX)
        for draw in range(4)
    ]
    seeds = [identity_seed(*person) for person in people]
    assert len(set(seeds)) == len(people)
    assert [SPLITS[seed % 3] for seed in seeds] == [split for split, _, _ in people]


def test_a_redrawn_seed_is_above_all_first_ones() -> None:
    assert identity_seed("train", 0, draw=1) == 3 * 2**40
    assert identity_seed("test", LARGEST_INDEX) < 3 * 2**40


def test_an_unknown_split_is_refused() -> None:
    with pytest.raises(ValueError, match="train, validation, test"):
        identity_seed("dev", 0)  # type: ignore[arg-type]  # the point of the test


def test_a_negative_index_is_refused() -> None:
    with pytest.raises(ValueError, match="index"):
        identity_seed("train", -1)


def test_an_index_beyond_all_people_is_refused() -> None:
    with pytest.raises(ValueError, match="index"):
        identity_seed("train", LARGEST_INDEX + 1)


def test_a_negative_draw_is_refused() -> None:
    with pytest.raises(ValueError, match="draw"):
        identity_seed("train", 0, draw=-1)
