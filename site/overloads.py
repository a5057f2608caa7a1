"""Makes functions that a stub has as overloads alone visible to mkdocstrings: the first overload has the docstring."""

from typing import Any

import griffe


class Overloads(griffe.Extension):
    """Puts the first overload of a function in the place of the function that a stub does not have."""

    def on_class(self, *, cls: griffe.Class, **_: Any) -> None:
        put_overloads(cls)

    def on_module(self, *, mod: griffe.Module, **_: Any) -> None:
        put_overloads(mod)


def put_overloads(owner: griffe.Class | griffe.Module) -> None:
    """Give a class or a module the first overload of each function that it does not have."""
    for name, overloads in owner.overloads.items():
        if name not in owner.members:
            owner.set_member(name, overloads[0])
