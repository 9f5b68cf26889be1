"""How does a report word its numbers? As lines of a table and one sentence a condition."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence, Set
from typing import Any

from lrsr.evaluation.multiplicity import holm_adjusted

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

_SOURCES = ("recogniser", "landmarks")
"""Parts of a condition that are told where there are several."""

_Records = Sequence[Mapping[str, Any]]
"""Rows or comparisons, as in ``results.json``."""


def report_lines(rows: _Records, comparisons: _Records) -> list[dict[str, Any]]:
    """Return each row with what the template prints besides: condition, interval, tests.

    Where there are several recognisers or sources of landmarks, these are part of the condition.

    Args:
        rows: Lines of the table, as of :func:`lrsr.experiments.table.evaluate`.
        comparisons: Its paired tests; each is found again in the line of its method. Those that
            remain significant at 5 % after Holm's correction for all of them are marked. That of
            the same method under another condition is "rival".
    """
    adjusted = holm_adjusted([comparison["p"] for comparison in comparisons])
    labels = method_labels(rows)
    settings = {row["option"]: row["setting"] for row in rows}
    tests: dict[object, dict[str, Any]] = {}
    rivals: dict[tuple[Any, ...], dict[str, Any]] = {}
    for test, p_holm in zip(comparisons, adjusted, strict=True):
        told = {
            "difference": _signed(test),
            "p": _format_p(test["p"], test["log10_p"]),
            "remains": p_holm < 0.05,
        }
        if not across_conditions(test):
            label = {"against_label": labels[test["against"]]}
            tests.setdefault(_place(test), {})[test["against"]] = told | label
            continue
        other = test["against_option"]
        if other == test["option"]:
            label = {"label": f"{test['against_ipd_px']:g} px"}
        else:
            label = {"label": settings.get(other, f"option {other}")}
        rivals[_place(test)] = told | label
    if len({rival["label"] for rival in rivals.values()}) > 1:
        for place, rival in rivals.items():
            rival["label"] = _differing(rival["label"], settings[place[1]])
    several = several_sources(rows)
    return [
        {**_line(row, tests.get(_place(row), {}), several), "rival": rivals.get(_place(row))}
        for row in rows
    ]


def across_conditions(test: Mapping[str, Any]) -> bool:
    """Tell whether a paired test is of one method under two conditions, not of two methods."""
    return any(test[f"against_{name}"] != test[name] for name in ("option", "ipd_px"))


def _signed(test: Mapping[str, Any]) -> str:
    """Write a difference with its sign, and as many digits as its interval bears."""
    known = test["low"] is not None and test["high"] is not None
    digits = _digits((test["high"] - test["low"]) / 4 if known else None)
    return f"{test['difference']:+.{digits}f}".replace("-", "−")


def _digits(error: float | None) -> int:
    """Return how many digits behind the point are worth writing: 3, more near to an AUC of 1.

    Example:
        >>> [_digits(error) for error in (0.02, 0.0002, 0.00001, 0.0, None)]
        [3, 4, 5, 3, 3]
    """
    return min(5, max(3, math.ceil(-math.log10(2 * error)))) if error else 3


def _differing(setting: str, other: str) -> str:
    """Return the parts of one setting in which it differs from another."""
    return ", ".join(part for part in setting.split(", ") if part not in other.split(", "))


def several_sources(rows: _Records) -> Set[str]:
    """Return which of recogniser and landmarks there are several of: each is a condition then."""
    return {name for name in _SOURCES if len({row[name] for row in rows}) > 1}


def best_methods(lines: _Records) -> Iterator[str]:
    """Yield a sentence for each condition of :func:`report_lines`: who is best, by how much."""
    for condition in dict.fromkeys(line["condition"] for line in lines):
        here = [line for line in lines if line["condition"] == condition and line["measured"]]
        if not here:
            yield f"{condition}: too few faces were found to measure anything."
            continue
        top = max(line["auc"] for line in here)
        best = [line for line in here if line["auc"] == top]
        if len(here) == 1:
            test = best[0]["rival"]
            against = f"; {_verdict(test, test['label'])}" if test else ""
            yield f"{condition}: the AUC of {_measured(best[0], ' is ')}{against}."
        elif len(best) > 1:
            names = ", ".join(line["label"] for line in best)
            yield f"{condition}: {names} share the highest AUC, {best[0]['area']}."
        else:
            missed = any(line["fta"] for line in here)
            yield f"{condition}: {_praise(best[0], missed=missed)}."


def extremes(lines: _Records) -> list[str]:
    """Return a sentence for each method: where it is best, where worst.

    None where settings are not told, or nothing has two of them.
    """
    names = ("recogniser", "landmarks", "label", "ipd_px")
    several = [name for name in names if len({line[name] for line in lines}) > 1]
    groups: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for line in lines:
        if line["setting"]:
            groups.setdefault(tuple(line[name] for name in several), []).append(line)
    return [
        _extremes([_part(name, value) for name, value in zip(several, key, strict=True)], some)
        for key, some in groups.items()
        if len(some) > 1
    ]


def _part(name: str, value: Any) -> str:
    if name == "ipd_px" and value is not None:
        return f"{value:g} px"
    return f"{value} landmarks" if name == "landmarks" else str(value)


def _extremes(who: Sequence[str], lines: _Records) -> str:
    measured = [line for line in lines if line["measured"]]
    told = f"{', '.join(who)}: the" if who else "The"  # a name stays as it is
    if not measured:
        return f"{told} faces found were too few to measure anything."
    areas = [line["auc"] for line in measured]
    told += f" AUC is highest with {_all_with(max(areas), measured)}"
    if min(areas) < max(areas):
        told += f"; lowest with {_all_with(min(areas), measured)}"
    tests = [line["rival"] for line in lines if line["rival"]]
    if not tests:
        return f"{told}."
    rivals = {test["label"] for test in tests}
    against = f" to {rivals.pop()}" if len(rivals) == 1 else ""
    remain = sum(test["remains"] for test in tests)
    return f"{told}; of {len(tests)} differences{against} {remain} remain after Holm's correction."


def _all_with(auc: float, lines: _Records) -> str:
    """Name the first condition of that area, and say how many more there are."""
    first, *others = [line for line in lines if line["auc"] == auc]
    more = f" (and {len(others)} more)" if others else ""
    return _measured({**first, "label": f"{first['setting']}{more}"})


def method_labels(rows: _Records) -> dict[str, str]:
    """Return the label of each method, in the order of the rows."""
    return {row["method"]: row["label"] for row in rows}


def condition_of(record: Mapping[str, Any], several: Set[str]) -> str:
    """Return what a report calls the condition of a record; scores of others may have none.

    Args:
        record: With option, ipd_px, landmarks and recogniser, each possibly None, and maybe
            setting: words in place of the option.
        several: Of :func:`several_sources`.
    """
    option, ipd_px, source = record["option"], record["ipd_px"], record["landmarks"]
    named = record.get("setting") or ("" if option is None else f"option {option}")
    words = [named[:1].upper() + named[1:]] if named else []
    words += [] if ipd_px is None else [f"IPD {ipd_px:g} px"]
    words += [f"{source} landmarks"] if "landmarks" in several and source is not None else []
    told = ", ".join(words) or "All pairs"
    return f"{record['recogniser']}. {told}" if "recogniser" in several else told


def _format_p(p: float, log10_p: float | None = None) -> str:
    r"""Write a p value with two digits, as a power of ten where it is small.

    Args:
        p: [0, 1].
        log10_p: Its decimal logarithm, where p itself underflows.

    Example:
        >>> [_format_p(p).replace("\u00a0", " ") for p in (0.43, 0.043, 0.00012, 0.0)]
        ['0.43', '0.043', '1.2 × 10⁻⁴', '0']
        >>> _format_p(0.0, log10_p=-400.5).replace("\u00a0", " ")
        '3.2 × 10⁻⁴⁰¹'
    """
    if p >= 0.00095:
        return f"{p:.2f}" if p >= 0.095 else f"{p:.2g}"
    if p > 0:
        log10_p = math.log10(p)
    if log10_p is None or not math.isfinite(log10_p):
        return "0"
    exponent = math.floor(log10_p)
    mantissa = f"{10 ** (log10_p - exponent):.1f}"
    if mantissa == "10.0":
        mantissa, exponent = "1.0", exponent + 1
    return f"{mantissa}\u00a0×\u00a010{str(exponent).translate(_RAISED)}"


def _place(record: Mapping[str, Any]) -> tuple[Any, ...]:
    names = ("recogniser", "option", "ipd_px", "landmarks", "method")
    return tuple(record[name] for name in names)


def _line(row: Mapping[str, Any], tests: Mapping[str, Any], several: Set[str]) -> dict[str, Any]:
    low, high, measured = row["low"], row["high"], row["auc"] is not None
    degenerate = row["std"] == 0
    outside = measured and (low <= 0 or high >= 1)
    cut = not degenerate and outside and row["logit_low"] is not None
    if cut:
        low, high = row["logit_low"], row["logit_high"]
    exact = degenerate or not measured
    digits = _digits(row["std"])
    return {
        **row,
        "condition": condition_of(row, several),
        "measured": measured,
        "digits": digits,
        "area": f"{row['auc']:.{digits}f}" if measured else "",
        "interval": "no interval" if exact else f"{low:.{digits}f} – {high:.{digits}f}",
        "low": low,
        "high": high,
        "cut": cut,
        "degenerate": degenerate,
        "tests": tests,
    }


def _praise(line: Mapping[str, Any], *, missed: bool) -> str:
    """Say who is best, and by how much; where faces were missed, that need not be the difference.

    A method that acquires the easy ones alone has a high area: it is tested on what its rival
    acquired, too.
    """
    clauses = [f"the highest AUC is that of {_measured(line)}"]
    both = ", where both found the face," if missed else ""
    clauses += [_verdict(test, f"{test['against_label']}{both}") for test in line["tests"].values()]
    return "; ".join(clauses)


def _verdict(test: Mapping[str, Any], rival: str) -> str:
    verdict = "" if test["remains"] else ", no difference shown"
    return f"against {rival} {test['difference']} (p\u00a0=\u00a0{test['p']}{verdict})"


def _measured(line: Mapping[str, Any], between: str = ", ") -> str:
    interval = "" if line["degenerate"] else f" [{line['interval']}]"
    return f"{line['label']}{between}{line['area']}{interval}"
