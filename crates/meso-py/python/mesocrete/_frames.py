"""Tables as frames of pandas or polars; each library is imported when it is asked for."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any

_LIBRARIES = ("pandas", "polars")


def framing(frame: object) -> Callable[[Mapping[str, Any]], Any]:
    """Return what makes a table of the kind `frame` from columns: of a library's name its `DataFrame`, of None the dict itself.

    Raises ImportError where the library is not installed: before any work.
    """
    if frame is None:
        return dict
    if not isinstance(frame, str):
        message = f'frame is of type {type(frame).__name__}; it must be "pandas", "polars" or None'
        raise TypeError(message)
    if frame not in _LIBRARIES:
        message = f'frame is "{frame}"; it must be "pandas", "polars" or None, for a dict of arrays'
        raise ValueError(message)
    try:
        library = importlib.import_module(frame)
    except ImportError as error:
        message = f"{frame} is not installed; get it with: pip install {frame}"
        raise ImportError(message) from error
    made: Callable[[Mapping[str, Any]], Any] = library.DataFrame
    return made
