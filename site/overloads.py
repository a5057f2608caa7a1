"""Makes functions that a stub has as overloads alone visible to mkdocstrings: the first overload has the docstring."""

from typing import Any

import griffe


class Overloads(griffe.Extension):
    """Puts the first overload of a function in the place of the function that a stub does not have."""

    def on_class(self, *, cls: griffe.Class, **_: Any) -> None:
        for name, overloads in cls.overloads.items():
            if name not in cls.members:
                cls.set_member(name, overloads[0])
