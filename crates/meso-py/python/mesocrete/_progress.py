"""Values of `progress=`: True for a bar on the terminal or in a notebook, or a callable."""

from __future__ import annotations

import inspect
import shutil
import sys
import time
from collections.abc import Callable
from typing import Any

# Seconds between two drawings, and between two lines where nobody sees a bar.
_REDRAW, _LINE = 0.1, 10.0


class Listener:
    """Pass (done, total) on to a callable, and the stage where it has a parameter of that name."""

    def __init__(self, told: Callable[..., object]) -> None:
        """Look once whether the callable wants the stage."""
        self._told = told
        try:
            self._staged = "stage" in inspect.signature(told).parameters
        except (TypeError, ValueError):
            self._staged = False

    def __call__(self, done: float, total: float, stage: str) -> object:
        """Report; False stops the work."""
        return self._told(done, total, stage=stage) if self._staged else self._told(done, total)

    def close(self) -> None:
        """Leave nothing behind."""


class Bar:
    """A bar of its own, one line wide, which is gone at the end; plain lines where stderr is no terminal."""

    def __init__(self, line: float | None = None) -> None:
        """Start the clock; `line` is the time between two lines where nobody sees a bar, seconds."""
        self._line = line
        self._started = self._drawn = time.monotonic()
        self._handle = _notebook()
        self._shown = False

    def __call__(self, done: float, total: float, stage: str) -> None:
        """Draw the share that is done, at most ten times a second."""
        now = time.monotonic()
        seen = self._handle is not None or sys.stderr.isatty()
        if now - self._drawn < (_REDRAW if seen else _LINE if self._line is None else self._line):
            return
        self._drawn, self._shown = now, True
        share = min(max(done / total if total else 0.0, 0.0), 1.0)
        seconds = f"{now - self._started:.0f} s"
        if self._handle is not None:
            self._handle.update(_Html(f"{stage} <progress value='{share:.4f}'></progress> {100 * share:.0f} %, {seconds}"))
        elif seen:
            columns = shutil.get_terminal_size().columns - 1
            text = f" {100 * share:3.0f} % {seconds}"
            width = max(columns - len(text) - max(len(stage), 8) - 2, 0)
            bar = ("=" * int(share * width)).ljust(width)
            sys.stderr.write("\r" + f"{stage:<8} {bar}{text}"[:columns])
            sys.stderr.flush()
        else:
            sys.stderr.write(f"{stage}: {100 * share:.0f} % after {seconds}\n")

    def close(self) -> None:
        """Take the bar away."""
        if self._handle is not None:
            self._handle.update(_Html(""))
        elif self._shown and sys.stderr.isatty():
            sys.stderr.write("\r\x1b[2K")
            sys.stderr.flush()


class _Html:
    """Text that a notebook shows as HTML."""

    def __init__(self, text: str) -> None:
        self._text = text

    def _repr_html_(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return ""


def _notebook() -> Any:
    """Return a display that can be updated, in a notebook; None elsewhere."""
    display = sys.modules.get("IPython.display")
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if display is None or shell is None or not hasattr(shell, "kernel"):
        return None
    return display.display(_Html(""), display_id=True)


def listener(progress: Any) -> Listener | Bar | None:
    """Return the listener to the progress of the work.

    Raises TypeError for anything but None, a bool or a callable.
    """
    if progress is None or progress is False:
        return None
    if progress is True:
        return Bar()
    if not callable(progress):
        name = type(progress).__name__
        message = f"progress is of type {name}; it must be True, or a callable that takes (done, total)"
        raise TypeError(message)
    return Listener(progress)
