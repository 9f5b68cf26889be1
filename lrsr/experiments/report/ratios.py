"""How is a likelihood ratio told in words?"""

from collections.abc import Mapping
from typing import Any


def ratio_words(ratio: Mapping[str, Any], level: float) -> str:
    """Return a ratio with its interval, and what limits it.

    Args:
        ratio: Fields of :class:`lrsr.evaluation.ratio.Ratio`.
        level: Of the interval.
    """
    words, interval = _plain(ratio["llr"]), ""
    if ratio["low"] is not None:
        words += f" [{_plain(ratio['low'])}, {_plain(ratio['high'])}]"
        interval = f" [{ratio['low']:+.2f}, {ratio['high']:+.2f}], {100 * level:g} % over people"
    words += f" (log10 {ratio['llr']:+.2f}{interval})"
    if ratio["cut"]:
        words += "; cut to what so many pairs can support"
    if ratio["beyond"]:
        words += "; the score is beyond all that were calibrated on"
    return words.replace("-", "\u2212")


def basis_words(ratio: Mapping[str, Any]) -> str:
    """Return how many scores a ratio stands on."""
    pairs = f"{ratio['n_genuine']:,} genuine and {ratio['n_impostor']:,} impostor scores"
    return f"{ratio['n_people']:,} people, {pairs}"


def _plain(llr: float) -> str:
    """Return LR with two digits, without a power of ten where it is no millions.

    Example:
        >>> [_plain(x) for x in (0.0, 1.08, 3.0, 9.2, -2.0)]
        ['1', '12', '1,000', '1.6e+09', '0.01']
    """
    value = float(f"{10**llr:.2g}")
    return f"{value:,.0f}" if 10 <= value < 1e6 else f"{value:.2g}"
