"""The result of `effective`."""

from __future__ import annotations

from typing import Any


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
