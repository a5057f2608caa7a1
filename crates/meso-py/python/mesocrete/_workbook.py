"""Sheets of a workbook as text, for sieve tables in .xlsx."""

from __future__ import annotations

import re
from collections.abc import Iterator
from os import PathLike
from typing import Any


def text(path: str | PathLike[str], sheet: str | None) -> str:
    """Return a sheet as text with tabs; numbers that are shown in per cent get their sign.

    Raises ValueError where openpyxl is missing, the sheet cannot be chosen, or a formula has no value.
    """
    try:
        from openpyxl import load_workbook  # type: ignore[import-untyped]
    except ImportError:
        message = "reading an .xlsx takes openpyxl: pip install openpyxl, or save the sheet as CSV"
        raise ValueError(message) from None
    try:
        shown, typed = (load_workbook(path, data_only=only) for only in (True, False))
    except Exception as error:
        message = f"it is no workbook that openpyxl reads ({error}); save the sheet as CSV"
        raise ValueError(message) from None
    # Numbers may be stored as text; a sheet of notes has digits, too.
    tests = (_has_numbers, _has_digits)
    names = next(filter(None, ([name for name in shown.sheetnames if has(shown[name])] for has in tests)), [])
    if sheet is None and len(names) != 1:
        message = f"{len(names)} of its sheets have numbers; choose one: sheet = {' or '.join(map(repr, names or shown.sheetnames))}"
        raise ValueError(message)
    name = names[0] if sheet is None else sheet
    if name not in shown.sheetnames:
        message = f"it has no sheet {name!r}; it has {', '.join(map(repr, shown.sheetnames))}"
        raise ValueError(message)
    rows = zip(shown[name].iter_rows(), typed[name].iter_rows(), strict=True)
    return "\n".join("\t".join(_cell(a, b) for a, b in zip(*row, strict=True)) for row in rows)


def _cells(sheet: object) -> Iterator[Any]:
    rows = getattr(sheet, "iter_rows", None)  # a sheet of a chart has none
    return (cell for row in rows() for cell in row) if rows else iter(())


def _has_numbers(sheet: object) -> bool:
    return any(cell.data_type == "n" and cell.value is not None for cell in _cells(sheet))


def _has_digits(sheet: object) -> bool:
    return any(cell.data_type == "s" and re.search(r"\d", cell.value) for cell in _cells(sheet))


def _cell(shown: object, typed: object) -> str:
    value, formula = getattr(shown, "value", None), getattr(typed, "value", None)
    if value is None and isinstance(formula, str) and formula.startswith("="):
        message = f"cell {getattr(typed, 'coordinate', '')} has a formula without a value; save the workbook in a spreadsheet program once"
        raise ValueError(message)
    if value is None:
        return ""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        # A sign in quotes or behind a backslash is text: such a number counts per cent already.
        percent = "%" in re.sub(r'"[^"]*"|\\.', "", getattr(shown, "number_format", "") or "")
        # Without an exponent, and with a point, so that no mark is taken for thousands.
        digits = f"{100 * value if percent else value:.10f}".rstrip("0")
        return f"{digits}0%" if percent else f"{digits}0"
    return " ".join(str(value).split())
