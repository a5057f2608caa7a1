"""Data sets: many labelled volumes from one call, with the metadata of each.

A case is packed, turned into arrays and forgotten. Its metadata are written last, so that a killed call goes on where it was.
The sink keeps the request, so that another one destroys nothing, and the hash of each file, so that damage is found.
Arrays are compressed by zlib alone, and the files have no times: equal calls give equal bytes.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import sys
import time
import warnings
import zipfile
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from numbers import Real
from operator import index
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._effective import Target
from ._executor import _BUILD, Submitter, Workers, on_threads, require
from ._frames import framing
from ._mesocrete import Packing, Spec, _Lock, _study_results, _StudyPlan, pack
from ._mesocrete import __version__ as _VERSION
from ._progress import listener
from ._scan import checked_options, scan as _scan
from ._study import _FULL, _LOCKED

_QUANTITIES = ("phase", "grain", "share", "distance", "scan")
# Labels have long runs: more than the fastest level saves a tenth of the space for thrice the time.
_LEVEL = 1
_CASES = "cases"
_REQUEST = f"{_CASES}/request.json"
_TOLD = {"mesocrete", "shape", "what", "over", "seed", "hash"}
# Labels of phases in images.
_LABELS = {"0": "mortar", "1": "itz", "2": "aggregate", "3": "void", "4": "fibre", "255": "outside"}
_HDF5 = (".h5", ".hdf5", ".hdf")
_MOST = 1_000_000
_MOST_JOBS = 1024
# Volumes of one call to another process, seconds after which it makes no further one, and calls for each worker at least.
_TOGETHER, _LONG, _PIECES = 16, 0.25, 8

# What is done in a case: its number, spec, seed and sampled values.
_Job = tuple[int, Spec, "int | None", dict[str, Any]]
# Number of a volume, shapes and kinds of its arrays, and the text of its metadata.
_Made = tuple[int, dict[str, Any], str]


class Dataset(Sequence[dict[str, Any]]):
    """The volumes of a data set, read when they are asked for; `dataset` returns one.

    `data[i]` is a dict: an array for each quantity, the volume's `number`, its sampled values and its targets. It is what PyTorch calls a
    map-style data set: `DataLoader(data)` collates volumes of equal shape, and workers get it by pickling. All metadata stand
    in `data.cases[i]`.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Open the data set that `dataset` wrote to `path`."""
        self.path = Path(path)
        self._store = _store(self.path)
        self.cases: list[dict[str, Any]] = self._store.cases()
        """Metadata of every case: number, seed, spec, sampled values, size of a voxel, figures of the packing."""

    def __len__(self) -> int:
        """Return the number of volumes."""
        return len(self.cases)

    def __getitem__(self, number: Any) -> Any:
        """Return the arrays of a volume, its number, sampled values and targets; of a slice, a list.

        Raises
        ------
        OSError
            If the files of the volume are damaged or lost.
        """
        if isinstance(number, slice):
            return [self[i] for i in range(*number.indices(len(self)))]
        case = self.cases[number]
        targets = {name: number for name, number in case.get("targets", {}).items() if not name.endswith("_error")}
        return {**case["values"], **targets, **self._store.read(case), "number": case["number"]}

    def table(self, frame: str | None = None) -> Any:
        """Return one row a case: number, seed, sampled values, targets and figures. `frame` is "pandas" or "polars", else a dict."""
        framed = framing(frame)
        rows = [_row(case) for case in self.cases]
        names = list(dict.fromkeys(name for row in rows for name in row))
        columns = {name: [row.get(name) for row in rows] for name in names}
        return framed(columns if frame else {name: np.array(values) for name, values in columns.items()})

    def __repr__(self) -> str:
        """Name the path and count the volumes."""
        what = ", ".join(self.cases[0]["arrays"]) if self.cases else "nothing"
        return f"Dataset({len(self):,} volumes of {what} in {str(self.path)!r})"


def dataset(
    n: int,
    sampler: Callable[[np.random.Generator], Any] | Sequence[Any] | Mapping[str, Any] | None = None,
    *,
    spec: Any = None,
    shape: int | Sequence[int] = 128,
    what: Sequence[str] = ("phase",),
    sink: str | os.PathLike[str] = "dataset",
    seed: int = 0,
    scan: Mapping[str, Any] | None = None,
    targets: Mapping[str, Any] | None = None,
    model: bool = False,
    jobs: int | None = None,
    executor: Submitter | None = None,
    shard: tuple[int, int] | None = None,
    overwrite: bool = False,
    progress: bool | Callable[..., object] | None = None,
) -> Dataset:
    """Pack `n` specimens and write each as labelled voxels, with its metadata.

    Parameters
    ----------
    n : int
        Number of volumes.
    sampler : callable, list or dict, optional
        A callable returns the spec of a volume, ``sampler(rng)``; `rng` is a `numpy.random.Generator` of that volume. A list
        has `n` specs. A dict maps dotted keys to ranges `(low, high)` or lists of values, of which a nested Latin
        hypercube is drawn: one value in each of `n` strata where `n` is a power of two. Absent: the seed alone differs.
    spec : None, dict, path or Spec
        Options that a dict as `sampler`, or none, is laid over.
    shape : int or triple
        Voxels along the longest side, or (nz, ny, nx), as for `Packing.voxelize`.
    what : sequence of str
        "phase", "grain", "share" and "distance" as for `Packing.voxelize`, and "scan", a grey image as `mc.scan` makes it.
    sink : path
        `NAME.zarr` (version 2, one chunk a volume), `NAME.h5` (through h5py) or a folder of `.npz` files.
    seed : int
        Seed of all draws. A spec without a seed gets one from it; a spec with one keeps it.
    scan : dict, optional
        Keywords of `mc.scan` for "scan".
    targets : dict, optional
        A number for each volume by its name: "diffusivity", "conductivity" or "modulus" with the axis "x", "y", "z" or "mean",
        as ``{"diffusivity": "x", "modulus": "mean"}``. A dict has keywords of `Packing.effective`, too, and under `of` the
        property of another name. A function of the packing returns any number; another code, or another value
        that it uses, is another request.
    model : bool
        Whether the packings are kept, too, as `models/NUMBER.json.gz`. Not in an `.h5`.
    jobs : int, optional
        Cases at the same time, default one per core. It changes the time, never the result.
    executor : concurrent.futures.Executor or dask.distributed.Client, optional
        Makes the volumes, as for `study`; all workers must see the sink. Instead of `jobs`.
    shard : (int, int), optional
        Part K of N: every N-th volume from the K-th on, beside processes that make the others, e.g. the tasks of an array. The last
        one completes the sink. Not in an `.h5`.
    overwrite : bool
        Whether the data set of another request in `sink` is replaced.
    progress : bool or callable, optional
        True shows a bar; a callable is called as ``progress(done, total)``.

    Returns
    -------
    Dataset
        After a kill or Ctrl-C, the same call makes the volumes that are missing or damaged. A larger `n` keeps the volumes
        that are there.

    Raises
    ------
    FileExistsError
        If `sink` holds volumes of another request, or more than `n`, and `overwrite` is False.
    BlockingIOError
        If another process makes volumes in `sink`, other than those of another part of N.
    ValueError, TypeError
        For an invalid option or spec, before any work, and for volumes of unequal shape in a `.zarr` or `.h5`.
    """
    for name, flag in (("model", model), ("overwrite", overwrite)):
        if not isinstance(flag, bool):
            message = f"{name} is {flag!r}; it must be True or False"
            raise TypeError(message)
    if jobs is not None and not (_is_whole(jobs) and 1 <= jobs <= _MOST_JOBS):
        message = f"jobs is {jobs!r}; it must be a whole number from 1 to {_MOST_JOBS}"
        raise ValueError(message)
    if jobs is not None and executor is not None:
        message = f"jobs is {jobs}, and the executor has its own workers; leave one of the two out"
        raise ValueError(message)
    pool = ThreadPoolExecutor(jobs or os.cpu_count() or 1)
    workers = Workers(pool if executor is None else executor)
    asked_targets = [Target(name, given) for name, given in _checked_dict("targets", targets).items()]
    request = _Request(shape, _checked_what(what), checked_options(_checked_dict("scan", scan)), asked_targets, model=model)
    n = _checked_count(n)
    cases = _sampled(n, sampler, spec, seed)
    identity = [request.identity(job) for job in cases]
    asked = request.described(sampler, spec, seed, identity[0])
    store = _store(Path(sink))
    store.refuse(request)
    part, of = _checked_shard(shard)
    if shard is not None and isinstance(store, _Hdf5):
        message = f"shard is {shard}; an .h5 is one file: take a folder or a .zarr as sink"
        raise ValueError(message)

    def make_room(other: str) -> None:
        if other and not overwrite:
            words = _words(asked, n)
            message = f"{sink} holds {other}; this request is of {words}: overwrite=True replaces it, or take another sink"
            raise FileExistsError(message)
        if other:
            store.clear()

    make_room(store.foreign())
    tell = listener(progress)
    lock = store.lock(asked["hash"], part, of)
    try:
        with _briefly(store, of):
            make_room(store.other(asked, identity))
            missing = store.begin(request, asked, identity)
        left = [number for number in missing if number % of == part - 1]
        own = len(range(part - 1, n, of))
        if left:
            jobs_left = [cases[number] for number in left]
            made = _made(jobs_left, request, store, workers, together=executor is not None)
            for done, one in enumerate(made, 1 + own - len(left)):
                with _briefly(store, of):
                    store.finish(one, len(cases))
                if tell is not None:
                    tell(done, own, "dataset")
        with _briefly(store, of):
            # The last part finds the volumes of all.
            if of == 1 or not store.begin(request, asked, identity):
                store.close()
    except OSError as error:
        if error.errno in _FULL:
            message = f"{error.strerror}; free some space, and the same call goes on"
            raise OSError(error.errno, message, str(sink)) from error
        raise
    finally:
        workers.close()
        # Threads that write would go on behind the caller's back.
        pool.shutdown(wait=True, cancel_futures=True)
        _LOCKED.discard(lock)
        lock.release()
        if tell is not None:
            tell.close()
    return Dataset(sink)


def of_command(request: str) -> int:
    """Make the data set that `mesocrete dataset` asks for; return the exit code."""
    asked = json.loads(request)
    over = asked.pop("sampler") or {}
    sampler = {key: (value["low"], value["high"]) if isinstance(value, dict) else value for key, value in _leaves(over)}
    try:
        made = dataset(asked.pop("n"), sampler, **asked)
    except FileExistsError as error:
        raise FileExistsError(str(error).replace("overwrite=True", "--force")) from error
    if asked["progress"]:
        print(f"wrote {made.path}: {len(made):,} volumes", file=sys.stderr)
    return 0


def _leaves(over: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the options of nested tables by their dotted keys; a range is a table with `low`."""
    for name, value in over.items():
        if isinstance(value, dict) and "low" not in value:
            yield from _leaves(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


@contextmanager
def _briefly(store: _Store, of: int) -> Iterator[None]:
    """Have the sink alone for a moment, where other processes make parts of it."""
    lock = _Lock.briefly(store.root) if of > 1 else None
    try:
        yield
    finally:
        if lock is not None:
            lock.release()


def _checked_shard(shard: Any) -> tuple[int, int]:
    given = (1, 1) if shard is None else shard
    if not isinstance(given, Sequence) or len(given) != 2 or not all(map(_is_whole, given)) or not 1 <= given[0] <= given[1]:
        message = f"shard is {shard!r}; it must be (K, N), whole numbers with K from 1 to N"
        raise ValueError(message)
    return int(given[0]), int(given[1])


def _is_whole(number: Any) -> bool:
    return not isinstance(number, bool) and hasattr(number, "__index__")


def _checked_dict(name: str, given: Any) -> Mapping[str, Any]:
    if given is None or isinstance(given, Mapping):
        return given or {}
    message = f"{name} is {given!r}; it must be a dict"
    raise TypeError(message)


class _Request:
    """What is made of every packing."""

    def __init__(
        self,
        shape: int | Sequence[int],
        what: Sequence[str],
        scan: Mapping[str, Any],
        targets: Sequence[Target],
        *,
        model: bool,
    ) -> None:
        self.shape = _checked_shape(shape)
        self.what = what
        self.scan = scan
        self.targets = targets
        self.model = model

    def described(self, sampler: Any, spec: Any, seed: int, first: str) -> dict[str, Any]:
        """Return what is asked for, but for the number of volumes; `first` is the identity of volume 0."""
        over = "a sampler" if callable(sampler) else "a list of specs"
        if sampler is None or isinstance(sampler, Mapping):
            over = ", ".join(f"{key} {_range_words(value)}" for key, value in (sampler or {}).items()) or "one spec"
        told: dict[str, Any] = {"mesocrete": _VERSION, "shape": self.shape, "what": self.what, "model": self.model}
        told |= {"over": over, "seed": seed}
        told["scan"] = self.scan if "scan" in self.what else {}
        if self.targets:
            told["targets"] = self._described_targets()
        told["hash"] = hashlib.sha256((json.dumps(told, default=_plain) + first).encode()).hexdigest()
        described: dict[str, Any] = json.loads(json.dumps(told, default=_plain))
        return described

    def identity(self, job: _Job) -> str:
        """Return the hash of all that decides the files of a case."""
        number, spec, seed, values = job
        told = [_VERSION, number, spec.to_dict(), seed, values, self.shape, self.what, self.scan, self.model]
        told += [self._described_targets()] if self.targets else []
        return hashlib.sha256(json.dumps(told, sort_keys=True, default=_plain).encode()).hexdigest()

    def make(self, job: _Job) -> tuple[Packing, dict[str, NDArray[Any]], dict[str, Any]]:
        """Return a packing, its arrays and its metadata."""
        number, spec, seed, values = job
        packing = pack(spec, seed=seed)
        arrays = {name: self._array(packing, name) for name in self.what}
        low, high = packing.bounds
        shape = next(iter(arrays.values())).shape
        longest = int(np.argmax(np.subtract(high, low)))
        record = {
            "mesocrete": _VERSION,
            "number": number,
            "hash": self.identity(job),
            "seed": packing.seed,
            "values": values,
            "voxel_size_mm": (high[longest] - low[longest]) / shape[2 - longest],
            "arrays": {name: {"shape": list(array.shape), "dtype": array.dtype.str} for name, array in arrays.items()},
            "targets": {name: number for target in self.targets for name, number in target.of(packing).items()},
            "figures": _study_results(packing),
            "spec": packing.spec.to_dict(),
        }
        return packing, arrays, record

    def _described_targets(self) -> dict[str, Any]:
        return {target.name: target.described() for target in self.targets}

    def _array(self, packing: Packing, name: str) -> NDArray[Any]:
        if name == "scan":
            return _scan(packing, shape=self.shape, seed=packing.seed, **self.scan)
        quantity: Any = name
        array: NDArray[Any] = packing.voxelize(what=quantity, shape=self.shape)
        return array


def _made(
    left: Sequence[_Job], request: _Request, store: _Store, workers: Workers, *, together: bool
) -> Iterator[_Made]:
    """Do all cases, some at a time; yield the metadata of each as it ends. Calls to other processes have some `together`."""
    lost = []
    size = min(_TOGETHER, max(len(left) // (_PIECES * max(workers.count(), 1)), 1)) if together else 1
    batches = deque(left[at : at + size] for at in range(0, len(left), size))
    for batch, ended in workers.done(batches, lambda batch: (_make, batch, request, store, _BUILD)):
        if ended is None and len(batch) == 1:
            lost.append(batch[0][0])
            continue
        yield from ended or ()
        left_over = batch[len(ended or ()) :]
        # Together where the call took long enough, one by one where one of these ended its worker.
        batches.extend([left_over] if ended and left_over else ([job] for job in left_over))
    if lost:
        message = f"every process that worked on volume {', '.join(map(str, lost))} was killed; the same call tries again"
        raise RuntimeError(message)


def _make(
    batch: Sequence[_Job], request: _Request, store: _Store, driver: tuple[str, str, str]
) -> list[_Made]:
    """Make volumes, on whatever machine, until that took long enough, and write their files; return their metadata."""
    require(driver)
    began, made = time.monotonic(), []
    for job in batch:
        try:
            made.append(_made_one(job, request, store))
        except Exception:
            # It comes again, as the first one.
            if made:
                break
            raise
        if time.monotonic() - began > _LONG:
            break
    return made


def _made_one(job: _Job, request: _Request, store: _Store) -> _Made:
    try:
        with on_threads(1):
            packing, arrays, record = request.make(job)
        record["files"] = store.write(job[0], arrays)
        if request.model:
            record["files"] |= store.write_model(job[0], packing)
    except (ValueError, TypeError) as error:
        message = f"volume {job[0]}: {error}"
        raise type(error)(message) from error
    # The text is made here: the driver has the records of all workers to write.
    return _told(record)


def _told(record: Mapping[str, Any]) -> _Made:
    return record["number"], record["arrays"], json.dumps({**record, "sum": _sum(record)}, indent=1, default=_plain)


class _Store:
    """A folder with a file for each array of a case, `cases/NUMBER.json` and `cases/request.json`."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def refuse(self, request: _Request) -> None:
        """Refuse a request that no such sink can hold."""

    def other(self, asked: Mapping[str, Any], identity: Sequence[str]) -> str:
        """Return what the sink holds of another request, in words; nothing if this request can go on there."""
        if foreign := self.foreign():
            return foreign
        request, records = self._request(), self._records()
        if not records:
            return "" if request or not any(self._own()) else "files of no data set"
        there = f"{len(records):,} volumes of {_words(request) if request else 'an unknown request'}"
        if request.get("hash") != asked["hash"]:
            named = (name for name in asked if name not in ("hash", "mesocrete") and request.get(name) != asked[name])
            differ = ", ".join("the sampler" if name == "over" else name for name in named)
            return there if _words(request)[:-10] != _words(asked)[:-10] else f"{there}, with another {differ or 'spec'}"
        if len(identity) <= max(records):
            return f"{there}, more than n = {len(identity)}"
        changed = [number for number, record in records.items() if record["hash"] != identity[number]]
        return f"{there}, and another volume {changed[0]}" if changed else ""

    def lock(self, work: str, part: int, of: int) -> _Lock:
        """Take a part of the sink, which other processes share that make the same in as many parts."""
        self.root.mkdir(parents=True, exist_ok=True)
        return _locked(_Lock(self.root.absolute(), f"{work[:16]}{of}", f"{part}-of-{of}"))

    def foreign(self) -> str:
        """Return what stands in the sink's place and is no such sink."""
        return "a file that is no data set" if self.root.exists() and not self.root.is_dir() else ""

    def clear(self) -> None:
        """Remove the files of the data set, and nothing else in its folder."""
        if self.root.exists() and not self.root.is_dir():
            self.root.unlink()
            return
        for path in list(self._own()):
            path.unlink()
            if path.parent != self.root and not any(path.parent.iterdir()):
                path.parent.rmdir()

    def _own(self) -> Iterator[Path]:
        """Find the files of a data set."""
        numbered = (self.root.glob("*.npz"), (self.root / _CASES).glob("*.json"), (self.root / "models").glob("*.json.gz"))
        yield from (path for paths in numbered for path in paths if path.name.split(".")[0].isdigit())
        fixed = (_REQUEST, f"{_CASES}/.zgroup", "models/.zgroup", ".zgroup", ".zattrs")
        yield from (path for name in fixed if (path := self.root / name).exists())

    def begin(self, request: _Request, asked: Mapping[str, Any], identity: Sequence[str]) -> list[int]:
        """Note what is asked for; return the numbers of the volumes to make."""
        # Files of this request without a record are those of a killed process, or of another one at work.
        if not self._records() and self._request() != asked:
            self.clear()
        for folder in (_CASES, *(["models"] if request.model else [])):
            (self.root / folder).mkdir(parents=True, exist_ok=True)
        if self._request() != asked:
            _write_json(self.root / _REQUEST, asked)
        return [number for number, name in enumerate(identity) if not self.has(number, name)]

    def has(self, number: int, identity: str) -> bool:
        """Whether a case is there with undamaged files."""
        record = self._record(number)
        return (
            record is not None
            and record["hash"] == identity
            and all(_hash(self.root / name) == digest for name, digest in record["files"].items())
        )

    def _request(self) -> dict[str, Any]:
        try:
            request: dict[str, Any] = json.loads((self.root / _REQUEST).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        return request if isinstance(request, dict) and request.keys() >= _TOLD else {}

    def _records(self) -> dict[int, dict[str, Any]]:
        numbers = sorted(int(path.stem) for path in (self.root / _CASES).glob("*.json") if path.stem.isdigit())
        records = {number: self._record(number) for number in numbers}
        return {number: record for number, record in records.items() if record is not None}

    def write(self, number: int, arrays: Mapping[str, NDArray[Any]]) -> dict[str, str]:
        """Write the arrays of a case; return its files and their hashes."""
        name = f"{number:06}.npz"
        with _whole(self.root / name) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL) as file:
            for key, array in arrays.items():
                with file.open(f"{key}.npy", "w", force_zip64=True) as member:
                    np.lib.format.write_array(member, array, allow_pickle=False)
        return {name: _hash(self.root / name) or ""}

    def write_model(self, number: int, packing: Packing) -> dict[str, str]:
        name = f"models/{number:06}.json.gz"
        packing.write(self.root / name)
        return {name: _hash(self.root / name) or ""}

    def finish(self, made: _Made, _count: int) -> None:
        """Write the metadata of a case, after its arrays."""
        number, _, text = made
        with _whole(self.root / _CASES / f"{number:06}.json") as part:
            part.write_text(text + "\n", encoding="utf-8")

    def close(self) -> None:
        """Write what describes all cases."""

    def cases(self) -> list[dict[str, Any]]:
        """Read the metadata of all cases."""
        records = self._records()
        if not records:
            message = f"{self.root} has no data set: mc.dataset(..., sink={str(self.root)!r}) makes one"
            raise FileNotFoundError(message)
        return list(records.values())

    def read(self, case: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """Read the arrays of a case."""
        with np.load(io.BytesIO(self._bytes(case, f"{case['number']:06}.npz"))) as file:
            return dict(file)

    def _bytes(self, case: Mapping[str, Any], name: str) -> bytes:
        """Return the bytes of a file of a case."""
        return _sound((self.root / name).read_bytes(), case, name, self.root)

    def _record(self, number: int) -> dict[str, Any] | None:
        try:
            record: dict[str, Any] = json.loads((self.root / _CASES / f"{number:06}.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return record if isinstance(record, dict) and record.get("sum") == _sum(record) else None


class _Zarr(_Store):
    """A group of zarr, version 2: an array for each quantity, a chunk for each volume."""

    def write(self, number: int, arrays: Mapping[str, NDArray[Any]]) -> dict[str, str]:
        files = {}
        for key, array in arrays.items():
            name = f"{key}/{number}.0.0.0"
            (self.root / key).mkdir(exist_ok=True)
            data = zlib.compress(np.ascontiguousarray(array).data, _LEVEL)
            with _whole(self.root / name) as part:
                part.write_bytes(data)
            files[name] = hashlib.sha256(data).hexdigest()
        return files

    def finish(self, made: _Made, count: int) -> None:
        """Describe the arrays with the first case; refuse others of another shape."""
        # Folders that zarr does not know would be warned about.
        for folder in (self.root, self.root / _CASES, self.root / "models"):
            if folder.is_dir() and not (folder / ".zgroup").exists():
                _write_json(folder / ".zgroup", {"zarr_format": 2})
        number, arrays, _ = made
        for key, array in arrays.items():
            described = self._described(array, count)
            path = self.root / key / ".zarray"
            there = json.loads(path.read_text(encoding="utf-8")) if path.exists() else None
            if there is not None and there["shape"][0] != count and there["shape"][1:] == described["shape"][1:]:
                there = None
            if there is None:
                there = described
                _write_json(path, described)
            if there != described:
                message = (
                    f"volume {number} has the shape {tuple(array['shape'])} and others {tuple(there['chunks'][1:])}; a folder "
                    "as sink takes volumes of all shapes"
                )
                raise ValueError(message)
        super().finish(made, count)

    def _described(self, array: Mapping[str, Any], count: int) -> dict[str, Any]:
        return {
            "zarr_format": 2,
            "shape": [count, *array["shape"]],
            "chunks": [1, *array["shape"]],
            "dtype": array["dtype"],
            "compressor": {"id": "zlib", "level": _LEVEL},
            "fill_value": 0,
            "order": "C",
            "filters": None,
        }

    def _own(self) -> Iterator[Path]:
        yield from super()._own()
        for name in _QUANTITIES:
            yield from (self.root / name).glob("*.0.0.0")
            yield from (path for file in (".zarray", ".zattrs") if (path := self.root / name / file).exists())
        yield from self.root.glob("zarr.json")

    def close(self) -> None:
        _write_json(self.root / ".zattrs", {"mesocrete": _VERSION, "cases": f"{_CASES}/NUMBER.json"})
        cases = self.cases()
        for name in cases[0]["arrays"]:
            _write_json(self.root / name / ".zattrs", _attributes(name, cases))

    def read(self, case: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        number = case["number"]
        return {name: _opened(self._bytes(case, f"{name}/{number}.0.0.0"), array) for name, array in case["arrays"].items()}


class _Hdf5(_Store):
    """An HDF5 file, made at the end from the chunks of a zarr group beside it, whose compressed bytes it takes as they are."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._parts = _Zarr(path.with_name(f".{path.name}.parts"))
        self._is_whole = False

    def refuse(self, request: _Request) -> None:
        if request.model:
            message = "model is True; an .h5 holds no models: take a folder or a .zarr as sink"
            raise ValueError(message)
        _h5py()

    def other(self, asked: Mapping[str, Any], identity: Sequence[str]) -> str:
        return super().other(asked, identity) if self.root.exists() else self._parts.other(asked, identity)

    def lock(self, work: str, part: int, of: int) -> _Lock:
        self.root.parent.mkdir(parents=True, exist_ok=True)
        return _locked(_Lock(self.root.absolute().parent, None, self.root.name))

    def foreign(self) -> str:
        if self.root.is_dir():
            return "a folder, which is no .h5"
        if not self.root.exists():
            return ""
        return "" if _h5py().is_hdf5(self.root) and self._request() else "a file that is no data set"

    def clear(self) -> None:
        super().clear()
        self._parts.clear()

    def begin(self, request: _Request, asked: Mapping[str, Any], identity: Sequence[str]) -> list[int]:
        """Find damaged and missing volumes; what is sound goes into the parts, unless all is."""
        records = self._records() if self.root.is_file() else {}
        sound = {number: chunks for number, record in records.items() if (chunks := self._chunks(record)) is not None}
        self._is_whole = len(sound) == len(identity)
        if self._is_whole:
            return []
        self._parts.begin(request, asked, [])
        for number, chunks in sound.items():
            for name, data in chunks.items():
                (self._parts.root / name).parent.mkdir(exist_ok=True)
                (self._parts.root / name).write_bytes(data)
            self._parts.finish(_told(records[number]), len(identity))
        return self._parts.begin(request, asked, identity)

    def write(self, number: int, arrays: Mapping[str, NDArray[Any]]) -> dict[str, str]:
        return self._parts.write(number, arrays)

    def finish(self, made: _Made, count: int) -> None:
        self._parts.finish(made, count)

    def close(self) -> None:
        """Put the chunks together, the whole file or none, and remove them."""
        import shutil

        if not self._is_whole:
            self._assemble()
        shutil.rmtree(self._parts.root, ignore_errors=True)

    def _assemble(self) -> None:
        cases = self._parts.cases()
        with _whole(self.root) as part, _h5py().File(part, "w") as file:
            file.attrs["mesocrete"] = _VERSION
            file.attrs["request"] = json.dumps(self._parts._request())
            file["case"] = [json.dumps(case) for case in cases]
            for name, array in cases[0]["arrays"].items():
                shape, dtype = tuple(array["shape"]), array["dtype"]
                options = {"chunks": (1, *shape), "compression": "gzip", "compression_opts": _LEVEL}
                volumes = file.create_dataset(name, (len(cases), *shape), dtype, **options)
                for key, value in _attributes(name, cases).items():
                    volumes.attrs[key] = json.dumps(value) if isinstance(value, (dict, list)) else value
                for case in cases:
                    chunk = (self._parts.root / name / f"{case['number']}.0.0.0").read_bytes()
                    volumes.id.write_direct_chunk((case["number"], 0, 0, 0), chunk)

    def cases(self) -> list[dict[str, Any]]:
        with _h5py().File(self.root, "r") as file:
            return [json.loads(text) for text in file["case"]]

    def read(self, case: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        chunks = self._chunks(case)
        if chunks is None:
            raise _damage(case, self.root)
        return {name: _opened(chunks[f"{name}/{case['number']}.0.0.0"], array) for name, array in case["arrays"].items()}

    def _request(self) -> dict[str, Any]:
        try:
            with _h5py().File(self.root, "r") as file:
                request: dict[str, Any] = json.loads(file.attrs.get("request", "{}"))
        except (OSError, ValueError):
            return {}
        return request

    def _records(self) -> dict[int, dict[str, Any]]:
        try:
            return {case["number"]: case for case in self.cases() if case.get("sum") == _sum(case)}
        except (OSError, ValueError, KeyError, RuntimeError):
            return {}

    def _chunks(self, record: Mapping[str, Any]) -> dict[str, bytes] | None:
        """Return the compressed bytes of a volume by their names in a zarr group; none if they are damaged."""
        chunks: dict[str, bytes] = {}
        try:
            with _h5py().File(self.root, "r") as file:
                for name, digest in record["files"].items():
                    data = file[name.split("/")[0]].id.read_direct_chunk((record["number"], 0, 0, 0))[1]
                    if hashlib.sha256(data).hexdigest() != digest:
                        return None
                    chunks[name] = data
        except (OSError, RuntimeError, ValueError, KeyError):
            return None
        return chunks


def _attributes(quantity: str, cases: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return what a reader needs to know of an array: one size of a voxel, or one for each volume."""
    sizes = [case["voxel_size_mm"] for case in cases]
    voxel_size_mm = sizes[0] if len(set(sizes)) == 1 else sizes
    legend = {"legend": _LABELS} if quantity == "phase" else {}
    return {"axes": ["volume", "z", "y", "x"], "voxel_size_mm": voxel_size_mm, **legend}


def _opened(data: bytes, array: Mapping[str, Any]) -> NDArray[Any]:
    """Return an array from its compressed bytes."""
    values: NDArray[Any] = np.frombuffer(bytearray(zlib.decompress(data)), dtype=array["dtype"]).reshape(array["shape"])
    return values


def _sound(data: bytes, case: Mapping[str, Any], name: str, root: Path) -> bytes:
    """Return the bytes of a file whose hash its case knows."""
    if hashlib.sha256(data).hexdigest() != case["files"][name]:
        raise _damage(case, root)
    return data


def _damage(case: Mapping[str, Any], root: Path) -> OSError:
    return OSError(f"volume {case['number']} of {root} is damaged; the same call of mc.dataset makes it again")


def _locked(lock: _Lock) -> _Lock:
    """Note a lock that forked processes leave to this one; warn where the disk has none."""
    _LOCKED.add(lock)
    if not lock.is_exclusive:
        warnings.warn("the disk of the sink has no locks: keep other processes out of it, or give each its shard", stacklevel=4)
    return lock


def _words(request: Mapping[str, Any], n: int | None = None) -> str:
    """Return a request in words."""
    shape, count = request["shape"], "" if n is None else f"{n:,} volumes, "
    told = shape if isinstance(shape, int) else " x ".join(map(str, shape))
    what = f"{count}shape {told}, {', '.join(request['what'])}, {request['over']}, seed {request['seed']}"
    return f"{what}, by version {request['mesocrete']} ({request['hash'][:8]})"


def _range_words(value: Any) -> str:
    return f"{value[0]} to {value[1]}" if isinstance(value, tuple) else f"one of {len(value)}"


def _store(path: Path) -> _Store:
    if path.suffix.lower() in _HDF5:
        return _Hdf5(path)
    return _Zarr(path) if path.suffix.lower() == ".zarr" else _Store(path)


def _h5py() -> Any:
    try:
        import h5py  # type: ignore[import-not-found, import-untyped, unused-ignore]
    except ImportError as error:
        message = "h5py is not installed; get it with: pip install h5py, or take a .zarr or a folder as sink"
        raise ImportError(message) from error
    return h5py


def _sampled(n: int, sampler: Any, spec: Any, seed: int) -> list[_Job]:
    """Draw all specs, and check each: the work begins when they are right."""
    if sampler is not None and spec is not None and not isinstance(sampler, Mapping):
        message = "spec is only for a dict as sampler; a callable and a list give whole specs"
        raise TypeError(message)
    if sampler is None or isinstance(sampler, Mapping):
        return _drawn(n, dict(sampler or {}), spec, seed)
    states = [np.random.SeedSequence(seed, spawn_key=(number,)) for number in range(n)]
    if callable(sampler):
        specs = [sampler(np.random.default_rng(state)) for state in states]
    else:
        specs = list(sampler)
        if len(specs) != n:
            message = f"sampler has {len(specs)} specs; it must have n = {n}"
            raise ValueError(message)
    return [_job(number, given, states[number]) for number, given in enumerate(specs)]


def _job(number: int, given: Any, state: np.random.SeedSequence) -> _Job:
    own = isinstance(given, Spec) or (isinstance(given, Mapping) and given.get("seed") is not None)
    try:
        complete = given if isinstance(given, Spec) else Spec(**given)
    except (TypeError, ValueError) as error:
        message = f"volume {number}: {error}"
        raise type(error)(message) from error
    return number, complete, None if own else _seed(state), {}


def _seed(state: np.random.SeedSequence) -> int:
    """Return a seed that JSON and every language keep."""
    return int(state.generate_state(1, np.uint64)[0] >> np.uint64(11))


def _drawn(n: int, ranges: Mapping[str, Any], spec: Any, seed: int) -> list[_Job]:
    """Draw a Latin hypercube of the ranges, which keeps the cases of a shorter one."""
    over = {key: _range(key, value) for key, value in ranges.items()}
    draw = {"cases": n, "design": "nested-hypercube", "seed": seed, "over": over}
    plan = _StudyPlan(dict(spec) if isinstance(spec, Mapping) else spec, {}, None, draw)
    own = "seed" in ranges

    def job(number: int) -> _Job:
        values = plan.values(number)
        if not own:
            del values["seed"]
        state = np.random.SeedSequence(seed, spawn_key=(number,))
        return number, plan.spec(number), None if own else _seed(state), values

    return [job(number) for number in range(n)]


def _range(key: str, value: Any) -> Any:
    """Return a pair as a range, and a list as it is."""
    if isinstance(value, tuple) and len(value) == 2:
        return {"low": value[0], "high": value[1]}
    if isinstance(value, (str, Mapping)) or not isinstance(value, Iterable):
        message = f"{key} is {value!r}; give a range (low, high) or a list; what is the same for all goes into spec="
        raise TypeError(message)
    return list(value)


def _checked_what(what: Sequence[str]) -> list[str]:
    names = [what] if isinstance(what, str) or not isinstance(what, Iterable) else list(what)
    wrong = [name for name in names if name not in _QUANTITIES]
    if wrong or not names:
        message = f"what is {what!r}; it must list some of {', '.join(_QUANTITIES)}"
        raise ValueError(message)
    return names


def _checked_shape(shape: Any) -> int | tuple[int, ...]:
    sides: list[Any] = [shape] if isinstance(shape, str) or not isinstance(shape, Iterable) else list(shape)
    if not all(map(_is_whole, sides)) or len(sides) not in (1, 3) or min(sides) < 1:
        message = f"shape is {shape!r}; it must be a positive int or three"
        raise (ValueError if all(map(_is_whole, sides)) else TypeError)(message)
    whole = tuple(map(index, sides))
    return whole if isinstance(shape, Iterable) else whole[0]


def _checked_count(n: int) -> int:
    if isinstance(n, bool) or not isinstance(n, Real):
        message = f"n is {n!r}; it must be an int"
        raise TypeError(message)
    if not (1 <= n <= _MOST and int(n) == n):
        message = f"n is {n}; it must be a whole number from 1 to {_MOST:,}"
        raise ValueError(message)
    return int(n)


def _row(case: Mapping[str, Any]) -> dict[str, Any]:
    names = ("number", "seed", "voxel_size_mm")
    return {**{name: case[name] for name in names}, **case["values"], **case.get("targets", {}), **case["figures"]}


def _sum(record: Mapping[str, Any]) -> str:
    """Return the hash of the metadata of a case."""
    told = json.loads(json.dumps({key: value for key, value in record.items() if key != "sum"}, default=_plain))
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def _hash(path: Path) -> str | None:
    """Return the hash of a file, if there is one."""
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None


def _plain(value: Any) -> Any:
    """Return a scalar or an array of numpy as JSON takes it."""
    if hasattr(value, "tolist"):
        return value.tolist()
    message = f"{type(value).__name__} does not fit JSON"
    raise TypeError(message)


def _write_json(path: Path, tree: Any) -> None:
    with _whole(path) as part:
        part.write_text(json.dumps(tree, indent=1) + "\n", encoding="utf-8")


class _whole:
    """A file that takes its name when it is complete."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._part = path.with_name(f".{path.name}.part")

    def __enter__(self) -> Path:
        return self._part

    def __exit__(self, kind: object, _error: object, _trace: object) -> None:
        if kind is None:
            self._part.replace(self._path)
        else:
            self._part.unlink(missing_ok=True)
