import numpy as np
import torch

from lrsr.training.order import EpochOrder


def order(seed: int = 0, batch_size: int = 4) -> EpochOrder:
    return EpochOrder(lambda rng: np.arange(10), batch_size=batch_size, seed=seed)


def rows(of: EpochOrder) -> list[int]:
    return torch.cat(list(of)).tolist()


def test_every_row_is_shown_once_in_full_batches() -> None:
    assert sorted(rows(order())) == list(range(10))
    assert [len(batch) for batch in order()] == [5, 5]
    assert [len(batch) for batch in order(batch_size=20)] == [10]
    assert len(order()) == 2


def test_the_order_follows_from_seed_and_epoch_alone() -> None:
    one, other = order(), order()
    first = rows(one)
    assert rows(one) == first
    one.set_epoch(1)
    assert rows(one) != first
    other.set_epoch(1)
    assert rows(other) == rows(one)
    assert rows(order(seed=1)) != first


def test_an_epoch_that_is_named_after_the_loop_began_still_counts() -> None:
    late, early = order(), order()
    started = iter(late)  # as Lightning does where it goes on
    late.set_epoch(3)
    early.set_epoch(3)
    assert torch.cat(list(started)).tolist() == rows(early)
