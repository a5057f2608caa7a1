"""Mesoscale concrete: aggregates packed without overlap, exact collision, meshes and Abaqus decks.

>>> import mesocrete as mc
>>> packing = mc.pack({"specimen": {"kind": "cube", "side_mm": 50}}, fraction=0.3)
>>> packing.write("model.vtu")

Units are mm, mm3, N, MPa, tonne and s; fractions go from 0 to 1 by volume of the specimen.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from . import gjk
    from ._mesocrete import (
        Aggregate,
        Aggregates,
        Frame,
        Mesh,
        Packing,
        Polyhedron,
        Response,
        Spec,
        __version__,
        convex_hull,
        effective,
        from_labels,
        load,
        pack,
        recipes,
    )
    from ._curves import Curves, mean_curves
    from ._dataset import Dataset, dataset
    from ._fit import Fit, fit
    from ._options import Grading, Materials, Specimen, Test
    from ._scan import scan
    from ._study import Study, study

__all__ = [
    "Aggregate",
    "Aggregates",
    "Curves",
    "Dataset",
    "Fit",
    "Frame",
    "Grading",
    "Materials",
    "Mesh",
    "Packing",
    "Polyhedron",
    "Response",
    "Spec",
    "Specimen",
    "Study",
    "Test",
    "__version__",
    "convex_hull",
    "dataset",
    "effective",
    "fit",
    "from_labels",
    "gjk",
    "load",
    "mean_curves",
    "pack",
    "recipes",
    "scan",
    "study",
]

# Names of the package's Python modules; all others are the compiled module's.
_HOMES = {
    "Curves": "_curves",
    "Dataset": "_dataset",
    "Fit": "_fit",
    "Grading": "_options",
    "Materials": "_options",
    "Specimen": "_options",
    "Study": "_study",
    "Test": "_options",
    "dataset": "_dataset",
    "fit": "_fit",
    "mean_curves": "_curves",
    "scan": "_scan",
    "study": "_study",
}


def __getattr__(name: str) -> object:
    """Import what has the name on its first use: numpy alone takes three times what a program's start may."""
    if name not in __all__:
        message = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(message)
    if name == "gjk":
        return import_module(".gjk", __name__)
    import_module("numpy")  # before the first array: Rust cannot raise what goes wrong there
    found: object = getattr(import_module(f".{_HOMES.get(name, '_mesocrete')}", __name__), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Name what is public, imported or not."""
    return sorted({*(name for name in globals() if name.startswith("_")), *__all__})
