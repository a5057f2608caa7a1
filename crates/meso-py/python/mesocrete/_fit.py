"""Fits: the mortar with which a specimen's curve meets a measured one.

Rust's `meso-study` chooses the points of a fit, for the command and for Python. Each point is a study over the seeds, whose
cases go to executors as those of `study` do.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ._executor import Submitter, require_threads
from ._mesocrete import Spec, _Fit
from ._study import _drive, _tree, _Way

if TYPE_CHECKING:
    from . import _types


class Fit:
    """The result of a fit; `fit()` returns one."""

    def __init__(self, state: _Fit, out: Path) -> None:
        """Keep the result of a fit whose folder is `out`."""
        self.out = out
        self.materials: _types.DeckMaterials = state.materials()
        """The materials at the best point, for the keyword `materials` of `Mesh.solve`."""
        self.report: dict[str, Any] = state.report()
        """The content of `fit.json`: `parameters`, `misfit`, `seeds`, `figures`, `measured`, `points`."""

    @property
    def parameters(self) -> dict[str, dict[str, float]]:
        """Every parameter of the mortar: its `value`, its scatter `over_packings` and the error `of_curve`."""
        found: dict[str, dict[str, float]] = self.report["parameters"]
        return found

    def __repr__(self) -> str:
        """Name the parameters and the misfit."""
        values = ", ".join(f"{key}={of['value']:.5g}" for key, of in self.parameters.items())
        return f"Fit({values}, misfit {self.report['misfit']:.2f})"


def fit(
    curve: str | os.PathLike[str] | Mapping[str, ArrayLike] | ArrayLike,
    spec: Spec | Mapping[str, object] | str | os.PathLike[str] | None = None,
    *,
    seeds: int = 3,
    steps: int = 6,
    friction: float | None = None,
    strain: float | None = None,
    law: str | None = None,
    element_size: float | None = None,
    min_gap: float | None = None,
    time_limit: float | None = None,
    accept_phase_error: bool = False,
    materials: _types.DeckMaterials | None = None,
    out: str | os.PathLike[str] = "fit",
    executor: Submitter | None = None,
    threads: int | None = None,
    progress: bool | Callable[[int, int], object] | None = None,
) -> Fit:
    """Find the mortar's strength, peak strain and energies with which a specimen's curve meets a measured one.

    Parameters
    ----------
    curve : path, dict or array_like
        The measured curve: a CSV file as for `mesocrete fit`, a dict with `strain` and `stress_mpa` like `Response.curve`, or
        rows of strain and stress, MPa, shape (n, 2).
    spec : None, dict, path or Spec
        The specimen that was tested.
    seeds : int
        Number of packings, of successive seeds from the spec's on; their scatter is the uncertainty.
    steps : int
        Most steps after the first five points; each tests every packing once.
    friction : float, optional
        Friction between plates and specimen; 0.1 if omitted.
    strain : float, optional
        Mean axial strain at the end; 1.15 times the last one of the curve if omitted.
    law : str, optional
        The law of mortar and ITZ, as for `Mesh.solve`.
    element_size : float, optional
        Size of an element, mm.
    min_gap : float, optional
        Smallest distance between two aggregates in every packing, mm.
    time_limit : float, optional
        End every packing after so many seconds with the best found; the results then depend on the machine.
    accept_phase_error : bool
        Whether a phase of a mesh may be more than 10 % off its exact volume.
    materials : dict, optional
        The materials to start from; absent values keep their illustrative defaults.
    out : path
        The folder of the fit: `materials.toml`, `fit.json`, and `cases` with every test.
    executor : concurrent.futures.Executor or dask.distributed.Client, optional
        Runs the tests, as for `study`.
    threads : int, optional
        For each test, as for `study`. It changes the time, never the result.
    progress : bool or callable, optional
        As for `study`, for the tests of each point.

    Returns
    -------
    Fit
        After a kill the same call goes on with the next test, and tests that failed run again.

    Raises
    ------
    ValueError, TypeError
        For options and curves that cannot be, before any work starts.
    OSError
        Where a file cannot be read or written.
    BlockingIOError
        Where another fit works in the folder `out`. Processes with the same call share its tests.
    RuntimeError
        Where a test failed.
    """
    options = {
        "seeds": seeds, "steps": steps, "friction": friction, "strain": strain, "law": law, "element_size_mm": element_size,
        "min_gap_mm": min_gap, "time_limit_s": time_limit, "accept_phase_error": accept_phase_error,
    }  # fmt: skip
    given = {key: value for key, value in options.items() if value is not None}
    require_threads(threads)
    file = curve if isinstance(curve, (str, os.PathLike)) else None
    points = _points(curve) if file is None else None
    folder = Path(out).absolute()
    state = _Fit(points, file, _tree(spec), given, _tree(materials), folder)
    try:
        while (plan := state.plan()) is not None:
            _drive(plan, state.cases, _Way(executor=executor, threads=threads, progress=progress))
            state.learn(plan)
        state.save("mesocrete.fit")
    finally:
        state.close()
    return Fit(state, folder)


def _points(curve: Any) -> list[tuple[float, float]]:
    """Return strain and stress of a curve in rows."""
    columns = isinstance(curve, Mapping)
    rows = np.column_stack([curve["strain"], curve["stress_mpa"]]) if columns else np.asarray(curve, float)
    if rows.ndim != 2 or rows.shape[1] != 2:
        message = f"curve has shape {rows.shape}; it must be rows of strain and stress, MPa, shape (n, 2)"
        raise ValueError(message)
    return [(float(strain), float(stress)) for strain, stress in rows]
