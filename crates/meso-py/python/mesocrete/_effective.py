"""The result of `effective`, and numbers of it as targets of data sets."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._executor import _BUILD, Submitter, Workers, on_threads, require
from ._fingerprint import fingerprint
from ._progress import listener


class Effective(dict[str, Any]):
    """An effective property: the content of `effective.json` but `seconds`, whose keys are attributes, too.

    >>> found = packing.effective(voxel_size=1)
    >>> found.tensor == found["tensor"]
    True
    """

    tensor: list[list[float | None]]
    error: list[list[float | None]]
    bounds: dict[str, Any]

    def __getattr__(self, name: str) -> Any:
        """Return the value of a key."""
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"an effective property has no {name!r}; it has {', '.join(self)}") from None

    def __dir__(self) -> list[str]:
        """List the keys with a dict's attributes."""
        return [*super().__dir__(), *self]


def of_many(
    labels: Iterable[Any], executor: Submitter, keywords: Mapping[str, Any], progress: bool | Callable[..., object] | None
) -> list[Any]:
    """Find the property of each label volume on the workers of an executor."""
    if isinstance(labels, (str, Path)) or (isinstance(labels, np.ndarray) and labels.ndim < 4):
        message = "labels is one volume; an executor does a sequence of them, as in [labels]"
        raise TypeError(message)
    volumes = list(labels)
    workers, tell = Workers(executor), listener(progress)
    found: list[Any] = [None] * len(volumes)
    try:
        calls = workers.done(deque(range(len(volumes))), lambda at: (_of_one, at, volumes[at], keywords, _BUILD))
        for done, (number, result) in enumerate(calls, 1):
            found[number] = result
            if tell is not None and tell(done, len(volumes), "effective") is False:
                message = "stopped: progress returned False"
                raise RuntimeError(message)
    finally:
        workers.close()
        if tell is not None:
            tell.close()
    lost = [number for number, result in enumerate(found) if result is None]
    if lost:
        message = f"every process that worked on volume {', '.join(map(str, lost))} was killed; take a machine with more memory"
        raise RuntimeError(message)
    return found


def _of_one(number: int, volume: Any, keywords: Mapping[str, Any], driver: tuple[str, str, str]) -> Any:
    """Find the property of a volume, on whatever machine."""
    from ._mesocrete import effective

    require(driver)
    try:
        with on_threads(1):
            return effective(np.load(volume) if isinstance(volume, (str, Path)) else volume, **keywords)
    except (ValueError, TypeError, RuntimeError) as error:
        message = f"volume {number}: {error}"
        raise type(error)(message) from error


_PROPERTIES = ("diffusivity", "conductivity", "modulus")
_AXES = ("x", "y", "z", "mean")
_KEYWORDS = ("voxel_size", "method", "element_size", "phases", "boundary", "tolerance")


class Target:
    """A number that a packing has: a property along an axis with its error, or what a function returns."""

    def __init__(self, name: str, given: Any) -> None:
        """Take an axis, keywords of `Packing.effective` with `of` and `axis`, or a function of the packing."""
        self.name = name
        self.function: Callable[[Any], Any] | None = given if callable(given) else None
        keywords = {} if self.function else {"axis": given} if isinstance(given, str) else given
        if not isinstance(keywords, Mapping):
            message = f"targets[{name!r}] is {given!r}; it must be an axis, a dict of keywords, or a function of the packing"
            raise TypeError(message)
        self.property = keywords.get("of", name)
        self.axis = keywords.get("axis", "mean")
        self.keywords = {key: value for key, value in keywords.items() if key not in ("of", "axis")}
        self._work = self._fingerprint() if self.function else ""
        if self.function is None:
            self._check()

    def _check(self) -> None:
        for key, value, known in (("of", self.property, _PROPERTIES), ("axis", self.axis, _AXES)):
            if value not in known:
                message = f"targets[{self.name!r}]: {key} is {value!r}; it must be one of {', '.join(known)}"
                raise ValueError(message)
        wrong = [key for key in self.keywords if key not in _KEYWORDS]
        if wrong:
            message = f"targets[{self.name!r}] has {wrong[0]!r}; it takes of, axis, {', '.join(_KEYWORDS)}"
            raise ValueError(message)

    def _fingerprint(self) -> str:
        try:
            return fingerprint(self.function)
        except TypeError as error:
            reason = str(error).partition(";")[0].replace("then", "it")
            message = f"targets[{self.name!r}]: {reason}, so that a change of it would not be seen; use plain values in it"
            raise TypeError(message) from error

    def described(self) -> dict[str, Any]:
        """Return what decides the number; of a function its name and the fingerprint of its code and values."""
        if self.function is not None:
            return {"function": self._work}
        return {"of": self.property, "axis": self.axis, **self.keywords}

    def of(self, packing: Any) -> dict[str, float]:
        """Return the number, and its error where that is known."""
        if self.function is not None:
            found = self.function(packing)
            try:
                return {self.name: float(found)}
            except (TypeError, ValueError) as reason:
                message = f"targets[{self.name!r}] returned {found!r}; it must be a number"
                raise type(reason)(message) from reason
        value, error = self._modulus(packing) if self.property == "modulus" else self._conduction(packing)
        return {self.name: value, f"{self.name}_error": error}

    def _conduction(self, packing: Any) -> tuple[float, float]:
        axes = "xyz" if self.axis == "mean" else self.axis
        found = packing.effective(self.property, axes=axes, **self.keywords)
        at = ["xyz".index(axis) for axis in axes]
        value, error = (float(np.mean([of[k][k] for k in at])) for of in (found.tensor, found.error))
        return value, error

    def _modulus(self, packing: Any) -> tuple[float, float]:
        found = packing.effective("stiffness", **self.keywords)
        stiffness, error = np.array(found.tensor), np.array(found.error)
        moduli = [_youngs_modulus(stiffness, error, axis) for axis in range(3)]
        kept = moduli if self.axis == "mean" else [moduli["xyz".index(self.axis)]]
        value, off = np.mean(kept, axis=0)
        return float(value), float(off)


def _youngs_modulus(stiffness: NDArray[Any], error: NDArray[Any], axis: int) -> tuple[float, float]:
    """Return Young's modulus along an axis, and its error to first order in the errors of the stiffness."""
    row = np.linalg.inv(stiffness)[axis]
    modulus = 1.0 / row[axis]
    return modulus, modulus**2 * float(np.abs(row) @ error @ np.abs(row))
