r"""How does a figure write names of any script? By whatever installed font has their letters.

Matplotlib's own font has Latin, Greek, Cyrillic, Hebrew, Arabic and others. What it lacks is taken
from the fonts of the machine, letter by letter; what none of these has is written as its code, such
as ``\u738b``, and the log says so. Pages and tables show every name as it is.
"""

import logging
from collections.abc import Iterable
from functools import cache

from matplotlib import rcParams
from matplotlib.figure import Figure
from matplotlib.font_manager import (
    FontEntry,
    FontProperties,
    findfont,
    fontManager,
    get_font,
    weight_dict,
)
from matplotlib.text import Text
from matplotlib.ticker import FixedLocator

_NO_LETTERS = ("lastresort", "emoji")
"""Fonts that have a box for everything, or pictures that Matplotlib cannot draw."""
_NORMAL = range(300, 501)
"""Weights."""

logger = logging.getLogger(__name__)


def write_any_script(figure: Figure) -> None:
    """Let a figure write all its words; to be called when they are all there.

    Args:
        figure: Texts, and labels of ticks that were given one by one.
    """
    axes_of = [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    listed = [axis for axis in axes_of if isinstance(axis.get_major_locator(), FixedLocator)]
    labels = [[label.get_text() for label in axis.get_ticklabels()] for axis in listed]
    texts = figure.findobj(Text)
    said = {*"".join(text.get_text() for text in texts)}.union(*map("".join, labels))
    lacking = frozenset(said) - _letters(_usual_font()) - {"\n"}
    if not lacking:
        return
    families, unknown = _fonts_with(lacking)
    for text in texts:
        text.set_fontfamily([*rcParams["font.family"], *families])
        text.set_text(_coded(text.get_text(), unknown))
    for axis, words in zip(listed, labels, strict=True):
        axis.set_ticklabels([_coded(word, unknown) for word in words])


def _coded(words: str, unknown: Iterable[str]) -> str:
    r"""Return words with the codes of some letters in place of these.

    Example:
        >>> print(_coded("王 & Müller", "王"))
        \u738b & Müller
    """
    return words.translate({ord(one): ascii(one)[1:-1] for one in unknown})


def _usual_font() -> str:
    """Return the file of the font that figures are written in."""
    return str(findfont(FontProperties(family=["sans-serif"])))


@cache
def _fonts_with(lacking: frozenset[str]) -> tuple[list[str], frozenset[str]]:
    """Return families of installed fonts that have some letters, and letters that none has."""
    families = []
    for entry in sorted(filter(_is_plain, fontManager.ttflist), key=_preference):
        if lacking & (known := _letters(entry.fname)):
            families.append(entry.name)
            lacking -= known
        if not lacking:
            break
    if lacking:
        logger.warning(
            "no installed font has %s: figures show codes such as %s in their place; install one,"
            " e.g. Noto Sans CJK",
            " ".join(sorted(lacking)),
            _coded(min(lacking), lacking),
        )
    return families, lacking


def _is_plain(entry: FontEntry) -> bool:
    weight = weight_dict.get(entry.weight, entry.weight)
    name = entry.name.lower().replace(" ", "")
    return (
        entry.style == "normal"
        and weight in _NORMAL
        and not any(word in name for word in _NO_LETTERS)
    )


def _preference(entry: FontEntry) -> tuple[bool, str, str]:
    return "Sans" not in entry.name, entry.name, str(entry.fname)


@cache
def _letters(file: str) -> frozenset[str]:
    """Return what a font can write; nothing if it is broken."""
    try:
        return frozenset(map(chr, get_font(file).get_charmap()))
    except (OSError, RuntimeError):  # as FreeType has it
        return frozenset()
