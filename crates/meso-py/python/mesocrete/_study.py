"""Studies: every combination of some options, on any executor, resumable, in one table.

Rust's `meso-study` plans and runs them for the command and for Python: combinations, hashes, folders, records, tables. Here
cases are handed to executors. Whoever works on a case has locked its folder, and records it.
"""

from __future__ import annotations

import errno
import importlib
import json
import math
import os
import signal
import sys
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypedDict, overload

import numpy as np
from numpy.typing import NDArray

from ._executor import _BUILD, Submitter, Workers, on_threads, require, require_device, require_threads
from ._fingerprint import fingerprint
from ._frames import framing
from ._mesocrete import Packing, Spec, _Lock, _StudyCase, _StudyPlan, _StudyRun, load, pack
from ._progress import Bar

if TYPE_CHECKING:
    import pandas as _pandas  # type: ignore[import-not-found, import-untyped, unused-ignore]
    import polars as _polars  # type: ignore[import-not-found, import-untyped, unused-ignore]
    import xarray as _xarray  # type: ignore[import-not-found, import-untyped, unused-ignore]
    from typing_extensions import NotRequired

    from ._types import EffectiveStep, MeshStep, SolveStep

_MODELS = ("model.json", "model.json.gz")


_Given = Spec | Mapping[str, object] | str | os.PathLike[str] | None


class Draw(TypedDict, total=False):
    """Random values of a study."""

    cases: int
    """Number of cases; required."""
    design: Literal["random", "latin-hypercube"]
    """Each value alone, or one from each of as many strata as there are cases."""
    seed: int
    """Seed of the draws, default 0."""
    over: Mapping[str, object]
    """From dotted keys to ranges ``{"low": 0.2, "high": 0.4}`` or lists of values."""


class CaseRecord(TypedDict):
    """The content of a case's `case.json`."""

    mesocrete: str
    """Version that ran it."""
    case: str
    """Its folder."""
    hash: str
    """Of the complete spec and the task."""
    then: str
    """Name of `then` with its version or its fingerprint; empty without `then`."""
    values: dict[str, object]
    """Values of the axes."""
    status: Literal["done", "failed"]
    """Whether it succeeded."""
    results: dict[str, object]
    """Results of `then`, or the figures of the packing."""
    error: NotRequired[str]
    """Message of the failure."""
    warnings: NotRequired[list[str]]
    """Warnings of the spec, the mesh, the test and the properties."""
    files: dict[str, int]
    """Every other file of the folder and its length, bytes."""
    model_sha256: NotRequired[str]
    """SHA-256 of the saved model."""
    sha256: str
    """SHA-256 of this record as compact JSON with an empty `sha256`."""


class Study:
    """The cases of a study and their results; `study()` returns one."""

    def __init__(self, plan: _StudyPlan, then: str, out: Path) -> None:
        """Read the study in the folder `out`."""
        self._plan = plan
        self._then = then
        self.out = out

    @property
    def keys(self) -> list[str]:
        """The axes, by their dotted keys."""
        return self._plan.keys

    @property
    def folders(self) -> list[Path]:
        """The cases' folders, the last axis running fastest."""
        return [self.out / name for name in self._plan.folders]

    @property
    def results(self) -> list[CaseRecord]:
        """The records of all cases that are over, as in their `case.json`: `case`, `values`, `status`, `results`, ..."""
        records: list[CaseRecord] = self._plan.results(self._then, self.out)
        return records

    @property
    def failures(self) -> dict[str, str]:
        """The message of every failed case, by its folder's name."""
        return {record["case"]: record["error"] for record in self.results if record["status"] == "failed"}

    def spec(self, number: int) -> Spec:
        """Return the complete spec of a case."""
        return self._plan.spec(number)

    def packing(self, number: int) -> Packing:
        """Read the packing of a case from its folder; pack it again where the study keeps none."""
        kept = _kept(self.folders[number])
        return load(kept) if kept.is_file() else pack(self._plan.packed_spec(number))

    @overload
    def table(self, frame: None = None) -> dict[str, NDArray[np.generic]]: ...
    @overload
    def table(self, frame: Literal["pandas"]) -> _pandas.DataFrame: ...
    @overload
    def table(self, frame: Literal["polars"]) -> _polars.DataFrame: ...
    @overload
    def table(self, frame: Literal["xarray"]) -> _xarray.Dataset: ...
    def table(self, frame: str | None = None) -> object:
        """Return one row a case, as in `table.csv`: a dict of arrays, or a frame; also writes the files anew.

        `table("pandas")` is a `pandas.DataFrame` with `attrs["units"]`, `table("polars")` a `polars.DataFrame`, and
        `table("xarray")` an `xarray.Dataset` along `case`, whose variables have `units`. Absent values are missing in frames, and in
        arrays NaN, or "" among texts. ImportError where the library is not installed.
        """
        framed = framing(frame)
        columns = self._plan.tables(self._then, self.out)[0]
        return framed(_wide(columns) if frame in ("pandas", "polars") else _arrays(columns))

    @overload
    def ensemble(self, replicate: str = "seed", *, frame: None = None) -> dict[str, NDArray[np.generic]]: ...
    @overload
    def ensemble(self, replicate: str = "seed", *, frame: Literal["pandas"]) -> _pandas.DataFrame: ...
    @overload
    def ensemble(self, replicate: str = "seed", *, frame: Literal["polars"]) -> _polars.DataFrame: ...
    @overload
    def ensemble(self, replicate: str = "seed", *, frame: Literal["xarray"]) -> _xarray.Dataset: ...
    def ensemble(self, replicate: str = "seed", *, frame: str | None = None) -> object:
        """Return mean and scatter over the axis `replicate`, for each combination of the others and each figure.

        The columns are the other axes, `figure`, `n`, `mean`, `std`, `cv`, `low` and `high` (95 % confidence interval of the
        mean, Student's t), and `needed`: how many repetitions of this scatter it takes until that interval's half-width is
        1 % of the mean. Over `seed` alone that is the scatter of packings, some 0.5 % of a strength, and not that of specimens,
        some 2.7 %. With an axis `solve.materials.scatter.seed` beside `seed`, repetitions are of both; `std_packing` and
        `std_material` are the scatter from each, with their standard errors. `frame` is as for `table`.
        """
        framed = framing(frame)
        columns = self._plan.ensemble(self._then, self.out, replicate)
        return framed(_wide(columns) if frame in ("pandas", "polars") else _arrays(columns))

    def __len__(self) -> int:
        """Return the number of cases."""
        return len(self._plan)

    def __repr__(self) -> str:
        """Name the folder and count the cases."""
        records = self.results
        failed = sum(record["status"] == "failed" for record in records)
        return f"Study({len(self):,} cases in {str(self.out)!r}: {len(records) - failed:,} done, {failed:,} failed)"


def study(
    spec: _Given | list[_Given] = None,
    over: Mapping[str, Iterable[object]] | None = None,
    *,
    zip: Mapping[str, Iterable[object]] | None = None,  # noqa: A002
    draw: Draw | None = None,
    outputs: Iterable[str] = (),
    mesh: MeshStep | None = None,
    solve: SolveStep | None = None,
    effective: EffectiveStep | None = None,
    model: Literal["json", "json.gz", "none"] = "json",
    layout: Literal["folders", "table"] | None = None,
    then: Callable[..., object] | None = None,
    version: str | int | None = None,
    out: str | os.PathLike[str] = "study",
    executor: Submitter | None = None,
    threads: int | None = None,
    retry_failed: bool = False,
    progress: bool | Callable[[int, int], object] | None = None,
) -> Study:
    """Do every combination of some options: pack, mesh, test, compute properties, call a function with each packing.

    Parameters
    ----------
    spec : None, dict, path or Spec, or a list of them
        Options that the values of `over` replace, as for `pack`. Each spec of a list is an axis' value; the column `spec`
        counts them from 0. The path of a STUDY.toml is a study of its own: it has all options of the cases.
    over : dict
        From the dotted key of an option to its values, e.g. ``{"seed": range(20), "grading.d_max_mm": [16, 20]}``. Options of
        the steps vary, too: ``"solve.friction": [0.0, 0.3]``. The last axis runs fastest.
    zip : dict, optional
        From dotted keys to lists of one length, whose values change together: one axis.
    draw : dict, optional
        Random values: ``{"cases": 50, "design": "latin-hypercube", "seed": 0, "over": {"fraction": {"low": 0.2, "high":
        0.4}, "grading.d_max_mm": [12, 16]}}``. `design` is "random" (default) or "latin-hypercube". Each case has a seed of
        its own.
    outputs : iterable of str
        Further files of each packing, by their names in the folder of a case: "grains.csv".
    mesh : dict, optional
        Meshes each packing: keywords of `Packing.mesh` and `Mesh.write`, and `output`, the names of the files. Figures of the
        mesh become columns that begin with `mesh.`.
    solve : dict, optional
        Tests each packing: keywords of `Mesh.solve` and `Packing.mesh`. The files of its results are in the folder of the case,
        its figures in columns that begin with `solve.`. A test with errors fails its case.
    effective : dict, optional
        Computes effective properties of each packing: keywords of `Packing.effective`. Files and columns as for `solve`.
    model : {"json", "json.gz", "none"}
        The packing that a finished case keeps. With "none", another `then` packs again.
    layout : {"folders", "table"}, optional
        How cases are kept: a folder each, with its files, or one file `records.jsonl` with the records of all. With "table" a finished
        case has no files, so that thousands of cases do not drown a shared disk. Absent: as the folder has them; a new one has
        folders.
    then : callable, optional
        Called as ``then(packing)`` or, if it takes two arguments, ``then(packing, folder)``; its result, a dict or a
        number, becomes columns of the table. It comes after the other steps, whose files are in the folder. Absent, and without
        steps: the figures of the packing's report.
    version : str or int, optional
        Names the work of `then`: results are kept under it, whatever `then` contains. Absent: a fingerprint of the code of
        `then` and of every value that it uses.
    out : path
        The study's folder: one folder for each case with `model.json` and `case.json`, `table.csv` and
        `ensemble.csv`; see `layout`.
    executor : concurrent.futures.Executor or dask.distributed.Client, optional
        Runs the cases; all workers must see the folder `out`. Absent: one case after the other, here.
    threads : int, optional
        For each case, and for calls in `then` that name no number; default all cores without an executor, 1 with one. It
        changes the time, never the result.
    retry_failed : bool
        Run failed cases again; finished cases are never repeated.
    progress : bool or callable, optional
        True shows a bar, in a notebook, too; a callable is called as ``progress(over, cases)``.

    Returns
    -------
    Study
        A case is identified by the hash of its complete spec and by `version` or the fingerprint of `then`: after a kill, the
        same call runs the remaining cases. A case that raises, or whose result JSON cannot hold, is recorded with its
        message, and the others go on.

    Raises
    ------
    ValueError, TypeError
        For an invalid combination, and for a `then` without a `version` that uses a value without readable content, like a
        lock, before any work starts.
    BlockingIOError
        Where another study works in the folder `out`. Processes with the same call share its cases.
    RuntimeError
        Where an executor lost its workers and cannot be renewed, where a worker has another build of mesocrete, and where one does
        not see the folder; finished cases are kept.
    """
    if model not in ("json", "json.gz", "none"):
        message = f'model is {model!r}; it must be "json", "json.gz" or "none"'
        raise ValueError(message)
    if layout not in (None, "folders", "table"):
        message = f'layout is {layout!r}; it must be "folders" or "table"'
        raise ValueError(message)
    require_threads(threads)
    steps = {"mesh": mesh, "solve": solve, "effective": effective, "outputs": list(outputs) or None}
    given = {name: step for name, step in steps.items() if step is not None}
    plan = _StudyPlan.of_file(spec) if isinstance(spec, (str, os.PathLike)) else None
    if plan is None:
        specs = [_tree(one) for one in spec] if isinstance(spec, list) else _tree(spec)
        axes = dict(over or {}), dict(zip) if zip else None, dict(draw) if draw is not None else None
        plan = _StudyPlan(specs, *axes, {"outputs": [], **given} if given else None, model)
    elif given or over or zip or draw is not None:
        message = f"{spec} is a study, which has its own steps and axes; change the file, or name a SPEC.toml"
        raise ValueError(message)
    name = fingerprint(then, version)
    _drive(plan, Path(out).absolute(), _Way(then, name, executor, threads, progress, retry_failed, layout))
    return Study(plan, name, Path(out).absolute())


def of_command(request: str) -> int:
    """Do the study that `mesocrete study --dask` asks for; return the exit code of the command."""
    asked = json.loads(request)
    try:
        client_of = importlib.import_module("distributed").Client
    except ImportError as error:
        message = 'dask is not installed; get it with: pip install "dask[distributed]"'
        raise ImportError(message) from error
    # The command's own answer to these would stop nothing here.
    for name in ("SIGINT", "SIGTERM"):
        signal.signal(getattr(signal, name), signal.default_int_handler)
    try:
        with client_of(asked.pop("dask")) as client:
            made = study(asked.pop("study"), executor=client, **asked)
    except KeyboardInterrupt:
        print("stopped; the same command goes on with the next case", file=sys.stderr)
        return 130
    for case, message in made.failures.items():
        print(f"warning: {case} failed: {message}", file=sys.stderr)
    failed = len(made.failures)
    if asked["progress"]:
        hint = "; --retry-failed runs them again" if failed else ""
        print(f"{len(made) - failed} of {len(made)} cases done, {failed} failed{hint}", file=sys.stderr)
    return 1 if failed else 0


class _Way(NamedTuple):
    """How the cases of a plan are done."""

    then: Callable[..., Any] | None = None
    name: str = ""
    executor: Submitter | None = None
    threads: int | None = None
    progress: bool | Callable[[int, int], object] | None = None
    retry_failed: bool = False
    layout: str | None = None


# Seconds between two looks at a case that another process works on.
_PAUSE = 0.1
# Seconds between two lines of a study where nobody sees a bar.
_MINUTE = 60.0
# A disk without room, or a user without quota.
_FULL = {errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)}


def _drive(plan: _StudyPlan, folder: Path, way: _Way) -> None:
    """Do the cases of a plan that are left."""
    then, name, executor, threads, progress, retry_failed, layout = way
    workers = None if executor is None else Workers(executor, then)
    if not isinstance(progress, bool | None) and not callable(progress):
        message = f"progress is of type {type(progress).__name__}; it must be a bool or a callable that takes (over, cases)"
        raise TypeError(message)
    run = _StudyRun(plan, name, folder, retry_failed, layout)
    tell = _teller(progress, run, len(plan), workers)
    _LOCKED.add(run)
    try:
        if not run.is_exclusive:
            message = f"the disk of {folder} has no locks: keep other processes out of the folder while this one works there"
            warnings.warn(message, stacklevel=3)
        tell()
        if workers is None:
            ended = _here(run, then, threads)
        else:
            ended = _there(run, workers, (then, 1 if threads is None else threads))
        for number, state in ended:
            run.note(number, state == "failed")
            tell()
    finally:
        tell(is_over=True)
        if workers is not None:
            workers.close()
        _LOCKED.discard(run)
        run.close()


# Runs and cases whose folders this process has locked. A forked process would keep the locks when this one is killed.
_LOCKED: set[_StudyRun | _StudyCase | _Lock] = set()


def _leave_locks() -> None:
    for locked in _LOCKED:
        locked.leave_lock_to_parent()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_locks)


def _run(case: _StudyCase, then: Callable[..., Any] | None, threads: int | None, driver: tuple[str, str, str]) -> str:
    """Do a case, on whatever machine, and record it; "done", "failed", or "busy" for a case of another process."""
    require(driver)
    require_device(case.find_device)
    state: str = case.begin()
    if state != "turn":
        return state
    _LOCKED.add(case)
    warned: list[str] = []
    try:
        try:
            packing, results, failure, warned = case.work(threads)
            if failure is None and then is not None:
                with on_threads(threads):
                    found = _results(then(packing, case.folder) if _takes_folder(then) else then(packing))
                results = json.dumps({**(json.loads(results) if case.has_steps else {}), **json.loads(found)})
        except Exception as error:
            # No case is to blame for a full disk, and each that is left would fail there.
            if isinstance(error, OSError) and error.errno in _FULL:
                raise
            results, failure = "{}", _message(error)
        return case.end(results, failure, warned)
    finally:
        case.leave()
        _LOCKED.discard(case)


def _here(run: _StudyRun, then: Callable[..., Any] | None, threads: int | None) -> Iterator[tuple[int, str]]:
    left = deque(run.left)
    while left:
        number = left.popleft()
        state = _run(run.case(number), then, threads, _BUILD)
        if state == "busy":
            left.append(number)
            time.sleep(_PAUSE)
        else:
            yield number, state


def _there(run: _StudyRun, workers: Workers, how: tuple[Callable[..., Any] | None, int]) -> Iterator[tuple[int, str]]:
    """Hand the cases to an executor; yield each as it ends, with its state."""
    left = deque(run.left)
    call = lambda number: (_run, run.case(number), *how, _BUILD)
    in_hand, memory = (lambda number: run.case(number).is_marked), (lambda number: run.case(number).memory)
    ended = workers.done(left, call, in_hand, memory)
    for number, told in ended:
        state = _poisoned(run.case(number)) if told is None else told
        if state == "busy":
            left.append(number)
            time.sleep(_PAUSE)
        else:
            run.seen(number)
            yield number, state


def _poisoned(case: _StudyCase) -> str:
    """Record the failure of a case whose workers died, unless another process has it."""
    state: str = case.begin()
    if state != "turn":
        return state
    needs = f"; it is estimated to take {case.memory / 1e9:.2g} GB" if case.memory else ""
    return case.end("{}", f"RuntimeError: every process that worked on the case was killed{needs}", [])


def _tree(spec: Any) -> Any:
    """Return a spec as the plan takes it."""
    return dict(spec) if isinstance(spec, Mapping) else spec


def _kept(folder: Path) -> Path:
    """Return the saved model of a case, or where it would be."""
    return next((path for name in _MODELS if (path := folder / name).is_file()), folder / _MODELS[0])


def _takes_folder(then: Callable[..., Any]) -> bool:
    from inspect import Parameter, signature

    parameters = signature(then).parameters.values()
    plain = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)
    return sum(p.kind in plain and p.default is Parameter.empty for p in parameters) > 1


def _results(value: Any) -> str:
    """Return the result of `then` as JSON; raise for a result that JSON cannot hold."""
    named = {} if value is None else value if isinstance(value, Mapping) else {"value": value}
    return json.dumps(_mapping(named, ""), allow_nan=False)


def _mapping(value: Mapping[Any, Any], place: str) -> dict[str, Any]:
    """Return a mapping by its names as text; a value that is missing, None or NaN, is left out."""
    kept: dict[str, Any] = {}
    for key, item in value.items():
        name = str(key)
        name.encode()
        if name in kept:
            message = f"two results have the name {place}{name}; rename one of them"
            raise ValueError(message)
        kept[name] = _plain(item, f"{place}{name}")
    return {name: item for name, item in kept.items() if item is not None}


def _plain(value: Any, place: str) -> Any:
    """Return a result as plain values; None where it is missing."""
    if isinstance(value, Mapping):
        return _mapping(value, f"{place}.")
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(item, f"{place}[{i}]") for i, item in enumerate(value)]
    if isinstance(value, float):
        if math.isinf(value):
            message = f"the result {place} is {value}; a result must be finite, or NaN where it is missing"
            raise ValueError(message)
        return None if math.isnan(value) else value
    if isinstance(value, int) and not -(2**63) <= value < 2**64:
        message = f"the result {place} is {value}; it does not fit 64 bits: return it as a float or a str"
        raise ValueError(message)
    if isinstance(value, str):
        value.encode()
    elif value is not None and not isinstance(value, int):
        message = f"the result {place} is of type {type(value).__name__}; it must be a number, a str, a bool, or a list or dict of them"
        raise TypeError(message)
    return value


def _message(error: Exception) -> str:
    """Return the type and the text of an error, which may have no text of its own."""
    try:
        text = f"{type(error).__name__}: {error}"
    except Exception:
        text = type(error).__name__
    return text.encode("utf-8", "backslashreplace").decode()


def _teller(
    progress: bool | Callable[[int, int], object] | None, run: _StudyRun, cases: int, workers: Workers | None
) -> Callable[..., None]:
    """Return the function that reports how far a run is; `is_over` ends it."""
    bar, begun, before = Bar(_MINUTE) if progress is True else None, time.monotonic(), run.over

    def show() -> None:
        over, minutes = run.over, (time.monotonic() - begun) / 60.0
        running = workers.running if workers is not None else int(over < cases)
        text = f"study: {over} of {cases}, {run.failed} failed, {running} running"
        if over > before:
            text += f", {(over - before) / minutes:.3g} a minute, {(cases - over) * minutes / (over - before):.0f} min left"
        if bar is not None:
            bar(over, cases, text)

    def tell(*, is_over: bool = False) -> None:
        if bar is not None:
            bar.close() if is_over else show()
        elif callable(progress) and not is_over:
            progress(run.over, cases)

    if bar is not None and workers is not None:
        workers.idle = show
    return tell


def _arrays(columns: Mapping[str, list[Any]]) -> dict[str, NDArray[np.generic]]:
    return {name: _array(values) for name, values in columns.items()}


def _wide(columns: Mapping[str, list[Any]]) -> dict[str, Any]:
    """Return columns for a frame: large whole numbers as arrays, since a library would make floats of them beside a gap."""
    wide = {name for name, values in columns.items() if any(isinstance(v, int) and abs(v) > 2**53 for v in values)}
    return {name: _array(values) if name in wide else values for name, values in columns.items()}


def _array(values: list[Any]) -> np.ndarray[Any, Any]:
    """Return a column as an array: missing numbers are NaN, missing texts "". Object arrays keep values that no other type holds."""
    if any(isinstance(value, str) for value in values) or all(value is None for value in values):
        return np.array(["" if value is None else value for value in values], dtype=np.str_)
    whole = [value for value in values if isinstance(value, int)]
    if None in values:
        if all(float(value) == value for value in whole):
            return np.array([math.nan if value is None else float(value) for value in values])
        return np.array(values, dtype=object)
    if whole and max(whole) >= 2**63:
        return np.array(values, dtype=np.uint64 if min(whole) >= 0 else object)
    return np.array(values)
