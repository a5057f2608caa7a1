"""Studies: every combination of some options, on any executor, resumable, in one table.

Combinations, hashes, folder names, records and tables are Rust's (`meso-study`), the same as the command's; here cases are
handed to executors.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypedDict, overload

import numpy as np
from numpy.typing import NDArray

from ._frames import framing
from ._mesocrete import Packing, Spec, _study_results, _study_write, _StudyPlan, load, pack
from ._progress import Bar

if TYPE_CHECKING:
    import pandas as _pandas  # type: ignore[import-not-found, import-untyped, unused-ignore]
    import polars as _polars  # type: ignore[import-not-found, import-untyped, unused-ignore]
    from typing_extensions import NotRequired

_MODEL = "model.json"


class Submitter(Protocol):
    """An `Executor` of `concurrent.futures`, or a client of `dask.distributed`."""

    @property
    def submit(self) -> Callable[..., object]:
        """Submit a call; returns its future."""


class CaseRecord(TypedDict):
    """The content of a case's `case.json`."""

    mesocrete: str
    """Version that ran it."""
    case: str
    """Its folder."""
    hash: str
    """Of the complete spec and the task."""
    then: str
    """Fingerprint of `then`; empty without one."""
    values: dict[str, object]
    """Values of the axes."""
    status: Literal["done", "failed"]
    """Whether it succeeded."""
    results: dict[str, object]
    """What `then` returned, or the figures of the packing."""
    error: NotRequired[str]
    """Message of the failure."""
    files: dict[str, int]
    """Every other file of the folder and its length, bytes."""


class Study:
    """The cases of a study and what they found; `study()` returns one."""

    def __init__(self, plan: _StudyPlan, then: str, out: Path) -> None:
        """Read what is in the folder `out`."""
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
        """Read the packing of a case from its folder."""
        return load(self.folders[number] / _MODEL)

    @overload
    def table(self, frame: None = None) -> dict[str, NDArray[np.generic]]: ...
    @overload
    def table(self, frame: Literal["pandas"]) -> _pandas.DataFrame: ...
    @overload
    def table(self, frame: Literal["polars"]) -> _polars.DataFrame: ...
    def table(self, frame: str | None = None) -> object:
        """Return one row a case, as in `table.csv`: a dict of arrays, or a frame; also writes the files anew.

        `table("pandas")` is a `pandas.DataFrame`, `table("polars")` a `polars.DataFrame`; values that a case lacks are
        missing there, and in arrays NaN, or "" among texts. ImportError where the library is not installed.
        """
        framed = framing(frame)
        columns = self._plan.tables(self._then, self.out)[0]
        return framed(_arrays(columns) if frame is None else columns)

    @overload
    def ensemble(self, replicate: str = "seed", *, frame: None = None) -> dict[str, NDArray[np.generic]]: ...
    @overload
    def ensemble(self, replicate: str = "seed", *, frame: Literal["pandas"]) -> _pandas.DataFrame: ...
    @overload
    def ensemble(self, replicate: str = "seed", *, frame: Literal["polars"]) -> _polars.DataFrame: ...
    def ensemble(self, replicate: str = "seed", *, frame: str | None = None) -> object:
        """Return mean and scatter over the axis `replicate`, for each combination of the others and each figure.

        The columns are the other axes, `figure`, `n`, `mean`, `std`, `cv`, `low` and `high` (95 % confidence interval of the
        mean, Student's t), and `needed`: how many repetitions of this scatter it takes until that interval's half-width is
        1 % of the mean. `frame` is as for `table`.
        """
        framed = framing(frame)
        columns = self._plan.ensemble(self._then, self.out, replicate)
        return framed(_arrays(columns) if frame is None else columns)

    def __len__(self) -> int:
        """Return the number of cases."""
        return len(self._plan)

    def __repr__(self) -> str:
        """Name the folder and count the cases."""
        records = self.results
        failed = sum(record["status"] == "failed" for record in records)
        return f"Study({len(self):,} cases in {str(self.out)!r}: {len(records) - failed:,} done, {failed:,} failed)"


def study(
    spec: Spec | Mapping[str, object] | str | os.PathLike[str] | None = None,
    over: Mapping[str, Iterable[object]] | None = None,
    *,
    then: Callable[..., object] | None = None,
    out: str | os.PathLike[str] = "study",
    executor: Submitter | None = None,
    threads: int | None = None,
    retry_failed: bool = False,
    progress: bool | Callable[[int, int], object] | None = None,
) -> Study:
    """Pack every combination of some options, and call a function with each packing.

    Parameters
    ----------
    spec : None, dict, path or Spec
        What the values of `over` are laid over, as for `pack`.
    over : dict
        From the dotted key of an option to its values, e.g. ``{"seed": range(20), "grading.d_max_mm": [16, 20]}``. The last
        axis runs fastest.
    then : callable, optional
        Called as ``then(packing)`` or, if it takes two arguments, ``then(packing, folder)``; what it returns, a dict or a
        number, becomes columns of the table. Absent: the figures of the packing's report.
    out : path
        The study's folder: one folder for each case with `model.json` and `case.json`, `table.csv` and
        `ensemble.csv`.
    executor : concurrent.futures.Executor or dask.distributed.Client, optional
        Runs the cases; all workers must see the folder `out`. Absent: one case after the other, here.
    threads : int, optional
        For each case; default all cores without an executor, 1 with one. It changes the time, never the result.
    retry_failed : bool
        Run failed cases again; finished cases are never repeated.
    progress : bool or callable, optional
        True shows a bar, in a notebook, too; a callable is called as ``progress(over, cases)``.

    Returns
    -------
    Study
        A case is identified by the hash of its complete spec and of the source of `then`: after a kill, the same call runs
        the remaining cases. A case that raises is recorded with its message, and the others go on.

    Raises
    ------
    ValueError, TypeError
        For an invalid combination, before any work starts.
    RuntimeError
        Where an executor lost its workers; finished cases are kept.
    """
    plan = _StudyPlan(dict(spec) if isinstance(spec, Mapping) else spec, dict(over or {}))
    folder = Path(out).absolute()
    name = _fingerprint(then)
    submit = _submitter(executor, then)
    folder.mkdir(parents=True, exist_ok=True)
    finished = {"done"} if retry_failed else {"done", "failed"}
    left = [number for number in range(len(plan)) if plan.state(number, name, folder) not in finished]
    tell = _teller(progress, len(plan))
    tell(len(plan) - len(left))
    if threads is None and submit is not None:
        threads = 1
    jobs = (_job(plan, number, name, folder, then, threads) for number in left)
    try:
        ended = _here(jobs) if submit is None else _there(jobs, submit)
        for count, (number, results, error) in enumerate(ended, len(plan) - len(left) + 1):
            _keep(plan, number, name, folder, results, error)
            tell(count)
    finally:
        tell(None)
        plan.tables(name, folder)
    return Study(plan, name, folder)


# What a worker needs to do a case: its number, spec, folder, function, threads, and whether the packing is there.
_Job = tuple[int, Spec, Path, Callable[..., Any] | None, int | None, bool]
_Ended = tuple[int, dict[str, Any], str | None]


def _job(
    plan: _StudyPlan, number: int, name: str, out: Path, then: Callable[..., Any] | None, threads: int | None
) -> _Job:
    packed = plan.prepare(number, name, out)
    return number, plan.spec(number), out / plan.folders[number], then, threads, packed


def _run(job: _Job) -> _Ended:
    """Do a case, on whatever machine; the results, or the message of its failure."""
    number, spec, folder, then, threads, packed = job
    try:
        packing = load(folder / _MODEL) if packed else pack(spec, threads=threads)
        if not packed:
            _study_write(packing, folder)
        if then is None:
            return number, _study_results(packing), None
        return number, _as_dict(then(packing, folder) if _takes_folder(then) else then(packing)), None
    except Exception as error:
        return number, {}, f"{type(error).__name__}: {error}"


def _here(jobs: Iterable[_Job]) -> Iterable[_Ended]:
    return map(_run, jobs)


def _there(jobs: Iterable[_Job], submit: Callable[..., Any]) -> Iterable[_Ended]:
    """Hand all cases to an executor; yield them as they end."""
    from concurrent.futures import BrokenExecutor, as_completed

    futures = [submit(_run, job) for job in jobs]
    lost = 0
    try:
        for future in as_completed(futures):
            try:
                yield future.result()
            except Exception as error:
                # dask's KilledWorker is no BrokenExecutor.
                if not isinstance(error, BrokenExecutor) and type(error).__name__ != "KilledWorker":
                    raise
                lost += 1
    finally:
        for future in futures:
            future.cancel()
    if lost:
        message = f"the executor lost its workers: {lost} cases are left; the same call with a new executor does them"
        raise RuntimeError(message)


def _keep(
    plan: _StudyPlan, number: int, name: str, out: Path, results: dict[str, Any], error: str | None
) -> None:
    """Write the record of a case, whose files must be here."""
    if error is None and not (out / plan.folders[number] / _MODEL).is_file():
        message = f"a worker wrote no {_MODEL} into {out}; all workers must see this folder (a shared file system)"
        raise RuntimeError(message)
    plan.record(number, name, out, results, error)


def _submitter(executor: Any, then: Callable[..., Any] | None) -> Callable[..., Any] | None:
    """Find how to hand work to an executor; a dask client gives an executor of its own."""
    if executor is None:
        return None
    # dask would take two cases with equal arguments for one; a case whose worker dies goes to another one.
    own = executor.get_executor(pure=False, retries=3) if hasattr(executor, "get_executor") else executor
    if not hasattr(own, "submit"):
        message = f"executor is of type {type(executor).__name__}; it must be a concurrent.futures.Executor or a dask client"
        raise TypeError(message)
    if then is not None and type(own).__name__ == "ProcessPoolExecutor":
        _check_picklable(then)
    submit: Callable[..., Any] = own.submit
    return submit


def _check_picklable(then: Callable[..., Any]) -> None:
    import pickle

    try:
        pickle.dumps(then)
    except Exception as error:
        message = f"then cannot be sent to another process ({error}); define it with def at the top of a module"
        raise TypeError(message) from error


def _takes_folder(then: Callable[..., Any]) -> bool:
    from inspect import Parameter, signature

    parameters = signature(then).parameters.values()
    plain = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)
    return sum(p.kind in plain and p.default is Parameter.empty for p in parameters) > 1


def _as_dict(value: Any) -> dict[str, Any]:
    """Return what `then` returned as a dict; what is not finite is left out."""
    if value is None:
        return {}
    named = dict(value) if isinstance(value, Mapping) else {"value": value}
    return {str(key): kept for key, item in named.items() if (kept := _plain(item)) is not None}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return _as_dict(value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _fingerprint(then: Callable[..., Any] | None) -> str:
    """Name a function by its module, name and source: a changed one makes its cases anew, from their packings."""
    if then is None:
        return ""
    import hashlib
    import inspect

    function = inspect.unwrap(getattr(then, "func", then))
    arguments = (getattr(then, "args", ()), getattr(then, "keywords", {})) if hasattr(then, "func") else ()
    try:
        source = inspect.getsource(function)
    except (OSError, TypeError):
        source = _code(getattr(function, "__code__", None))
    digest = hashlib.sha256(f"{source}{arguments!r}".encode()).hexdigest()[:16]
    return f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', type(then).__qualname__)}:{digest}"


def _code(code: Any) -> str:
    """Return the code of a function that has no source, without names of files and addresses."""
    if code is None:
        return ""
    constants = [_code(item) if hasattr(item, "co_code") else repr(item) for item in code.co_consts]
    return repr((code.co_code, code.co_names, constants))


def _teller(progress: bool | Callable[[int, int], object] | None, cases: int) -> Callable[[int | None], None]:
    """Return what is called with the number of cases that are over, and with None at the end."""
    if not progress:
        return lambda _: None
    if progress is True:
        bar = Bar()
        return lambda over: bar.close() if over is None else bar(over, cases, f"study: {over} of {cases}")
    if not callable(progress):
        message = f"progress is of type {type(progress).__name__}; it must be a bool or a callable that takes (over, cases)"
        raise TypeError(message)
    return lambda over: None if over is None else (progress(over, cases), None)[1]


def _arrays(columns: Mapping[str, list[Any]]) -> dict[str, NDArray[np.generic]]:
    return {name: _array(values) for name, values in columns.items()}


def _array(values: list[Any]) -> np.ndarray[Any, Any]:
    """Return a column as an array: missing numbers are NaN, missing texts ""."""
    if any(isinstance(value, str) for value in values) or all(value is None for value in values):
        return np.array(["" if value is None else value for value in values], dtype=np.str_)
    if None in values:
        return np.array([math.nan if value is None else float(value) for value in values])
    return np.array(values)
