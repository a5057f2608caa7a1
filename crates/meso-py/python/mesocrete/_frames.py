"""Tables as frames of pandas or polars, or as a data set of xarray; each library is imported when it is asked for."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any

_LIBRARIES = ("pandas", "polars", "xarray")
# Endings of names, and the units that they mean.
_UNITS = {
    "_n_per_mm": "N/mm",
    "_mm_per_s": "mm/s",
    "_mm3": "mm^3",
    "_mm2": "mm^2",
    "_mm": "mm",
    "_mpa": "MPa",
    "_percent": "%",
    "_n": "N",
    "_s": "s",
}


def framing(frame: object) -> Callable[[Mapping[str, Any]], Any]:
    """Return what makes a table of the kind `frame` from columns: of a library's name its `DataFrame`, of None the dict itself.

    Raises ImportError where the library is not installed: before any work.
    """
    if frame is None:
        return dict
    if not isinstance(frame, str):
        message = f'frame is of type {type(frame).__name__}; it must be "pandas", "polars", "xarray" or None'
        raise TypeError(message)
    if frame not in _LIBRARIES:
        message = f'frame is "{frame}"; it must be "pandas", "polars", "xarray" or None, for a dict of arrays'
        raise ValueError(message)
    try:
        library = importlib.import_module(frame)
    except ImportError as error:
        message = f"{frame} is not installed; get it with: pip install {frame}"
        raise ImportError(message) from error
    if frame == "polars":
        made: Callable[[Mapping[str, Any]], Any] = library.DataFrame
        return made
    return (lambda columns: _pandas(columns, library)) if frame == "pandas" else (lambda columns: _xarray(columns, library))


def _units(name: str) -> str | None:
    """Return the unit that the end of a column's name means."""
    return next((unit for end, unit in _UNITS.items() if name.endswith(end)), None)


def _pandas(columns: Mapping[str, Any], pandas: Any) -> Any:
    frame = pandas.DataFrame(columns)
    frame.attrs["units"] = {name: unit for name in columns if (unit := _units(name))}
    return frame


def _xarray(columns: Mapping[str, Any], xarray: Any) -> Any:
    """Return a data set along `case`, or along `row` where the rows are no cases."""
    along = "case" if "case" in columns else "row"
    attributes = {name: {"units": unit} if (unit := _units(name)) else {} for name in columns}
    return xarray.Dataset({name: (along, values, attributes[name]) for name, values in columns.items()})
