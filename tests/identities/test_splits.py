import pytest

from lrsr.identities.splits import SPLITS, Split, identity_seed, split_of


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
    assert {split_of(identity_seed(split, index)) for index in range(50)} == {split}


def test_an_unknown_split_is_refused() -> None:
    with pytest.raises(ValueError, match="train, validation, test"):
        identity_seed("dev", 0)  # type: ignore[arg-type]  # the point of the test


def test_a_negative_index_is_refused() -> None:
    with pytest.raises(ValueError, match="index"):
        identity_seed("train", -1)


def test_a_negative_seed_has_no_split() -> None:
    with pytest.raises(ValueError, match="seed"):
        split_of(-1)
