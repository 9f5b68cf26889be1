from dataclasses import dataclass
from typing import Any

import pytest

from lrsr.errors import InputError
from lrsr.training.augmentation.ranges import SHARE, check_ranges


@dataclass(frozen=True)
class Settings:
    share: float = 0.5
    span: tuple[float, float] = (0.0, 1.0)
    pair: tuple[float, float] = (1.0, 0.0)

    def __post_init__(self) -> None:
        check_ranges(self, "s", {"share": SHARE, "span": SHARE, "pair": SHARE}, spans=["span"])


def test_fields_get_their_types() -> None:
    assert Settings(1, [0, 1]) == Settings(1.0, (0.0, 1.0))  # type: ignore[arg-type]  # as of YAML


def test_a_pair_that_is_no_span_has_no_order() -> None:
    assert Settings(pair=(1.0, 0.0)).pair == (1.0, 0.0)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"share": 1.01}, "s.share=1.01: wanted 0 to 1$"),
        ({"share": "much"}, "s.share=much: wanted a number"),
        ({"span": (0.7, 0.2)}, r"s.span=\[0.7,0.2\]: wanted 0 to 1, the least first"),
        ({"span": 1}, "s.span=1: wanted two numbers"),
        ({"pair": (0.0, 2.0)}, r"s.pair=\[0,2\]: wanted 0 to 1$"),
    ],
    ids=str,
)
def test_what_cannot_be_is_refused_by_name(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Settings(**wrong)
