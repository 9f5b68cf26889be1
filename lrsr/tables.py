"""What does a table say, whichever program saved it? Rows of text by the names of columns."""

import codecs
import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.files import read_bytes

_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def open_table(path: Path, remedy: str) -> Any:
    """Return what ``csv.reader`` returns of a table, as any program may have saved it.

    A mark of the byte order, UTF-16 behind one, other ends of lines, and semicolons or tabs between
    columns are all fine.

    Raises:
        InputError: It cannot be read: the message ends in ``remedy``, or it is no UTF-8.
    """
    try:
        content = read_bytes(path)
        text = content.decode("utf-16" if content.startswith(_UTF_16) else "utf-8-sig")
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"cannot read {path}: {reason}; {remedy}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"cannot read {path}: {error}; save it as UTF-8") from error
    text = text.lstrip("\ufeff")  # two programs may have put a mark each
    head = text.partition("\n")[0]
    separator = max(",;\t", key=head.count)
    return csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)


def read_rows(
    path: Path, needed: Sequence[str], remedy: str
) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield the number of each line that is not blank, and its cells by column.

    Cells that are missing at a line's end are empty.

    Args:
        path: See :func:`open_table`.
        needed: Columns that must be there.
        remedy: What to do about a file that cannot be read.

    Raises:
        InputError: It cannot be read, a column is missing or there twice, or a line is longer than
            the first; the message names file and line.
    """
    reader = open_table(path, remedy)
    try:
        rows = (cells for cells in reader if "".join(cells).strip())  # tables end in blank lines
        names = [name.strip() for name in next(rows, [])]
        for name in needed:
            if name not in names:
                there = ", ".join(filter(None, names))[:200]
                raise InputError(
                    f"{path}, line 1: no column {name} among {there or 'none'}; add it"
                )
        for name in filter(None, names):
            if names.count(name) > 1:
                raise InputError(f"{path}, line 1: {names.count(name)} columns {name}; rename one")
        for cells in rows:
            if "".join(cells[len(names) :]).strip():
                raise InputError(
                    f"{path}, line {reader.line_num}: {len(cells)} cells for {len(names)} columns;"
                    ' put text that holds a separator between "quotes"'
                )
            cells += [""] * (len(names) - len(cells))
            yield reader.line_num, dict(zip(names, cells, strict=False))
    except csv.Error as error:
        raise InputError(f"{path}, line {reader.line_num}: {error}; make it again") from error
