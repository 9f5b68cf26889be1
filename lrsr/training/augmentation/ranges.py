"""Are the numbers of an augmentation possible? All are checked alike."""

from collections.abc import Collection, Mapping
from typing import Any

from lrsr.configuration import require, settle

Limits = Mapping[str, tuple[float, float]]
SHARE = (0.0, 1.0)


def check_ranges(instance: Any, group: str, limits: Limits, *, spans: Collection[str] = ()) -> None:
    """Give the fields of an augmentation their types, and refuse what cannot be.

    Args:
        instance: A frozen dataclass, just made.
        group: What messages call it.
        limits: Lowest and highest value of each field, be it a number or a pair.
        spans: Which pairs are the least and the most, in this order.

    Raises:
        InputError: A field is of another kind, or out of its limits.
    """
    settle(instance, group)
    for name, (low, high) in limits.items():
        value = getattr(instance, name)
        values = value if isinstance(value, tuple) else (value,)
        holds = all(low <= one <= high for one in values)
        if name in spans:
            holds = holds and values == tuple(sorted(values))
        wish = f"{low:g} to {high:g}{', the least first' if name in spans else ''}"
        shown = f"[{','.join(f'{one:g}' for one in values)}]" if values is value else f"{value:g}"
        require(holds, f"{group}.{name}", shown, wish)
