"""Data sets: many labelled volumes from one call, with the metadata of each.

A case is packed, turned into arrays and forgotten. Its metadata are written last, so that a killed call goes on where it was.
Arrays are compressed by zlib alone, and the files have no times: equal calls give equal bytes.
"""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._frames import framing
from ._mesocrete import Packing, Spec, _study_results, _StudyPlan, pack
from ._mesocrete import __version__ as _VERSION
from ._progress import listener
from ._scan import checked_options, scan as _scan

_QUANTITIES = ("phase", "grain", "share", "distance", "scan")
# Labels have long runs: more than the fastest level saves a tenth of the space for thrice the time.
_LEVEL = 1
_CASES = "cases"
_HDF5 = (".h5", ".hdf5", ".hdf")
_MOST = 1_000_000

# What is done in a case: its number, spec, seed and sampled values.
_Job = tuple[int, Spec, "int | None", dict[str, Any]]


class Dataset(Sequence[dict[str, Any]]):
    """The volumes of a data set, read when they are asked for; `dataset` returns one.

    `data[i]` is a dict: an array for each quantity, and `case`, the metadata. It is what PyTorch calls a map-style data set,
    and it pickles, so that workers can load volumes.
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
        """Return the arrays of a volume and its metadata; of a slice, a list."""
        if isinstance(number, slice):
            return [self[i] for i in range(*number.indices(len(self)))]
        case = self.cases[number]
        return {**self._store.read(case), "case": case}

    def table(self, frame: str | None = None) -> Any:
        """Return one row a case: number, seed, sampled values and figures. `frame` is "pandas" or "polars", else a dict."""
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
    model: bool = False,
    jobs: int | None = None,
    progress: bool | Callable[..., object] | None = None,
) -> Dataset:
    """Pack `n` specimens and write each as labelled voxels, with its metadata.

    Parameters
    ----------
    n : int
        Number of volumes.
    sampler : callable, list or dict, optional
        A callable returns the spec of a volume, ``sampler(rng)``; `rng` is a `numpy.random.Generator` of that volume. A list
        has `n` specs. A dict maps dotted keys to ranges `(low, high)` or lists of values, of which a Latin hypercube is
        drawn. Absent: the seed alone differs.
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
    model : bool
        Whether the packings are kept, too, as `models/NUMBER.json.gz`. Not in an `.h5`.
    jobs : int, optional
        Cases at the same time, default one per core. It changes the time, never the result.
    progress : bool or callable, optional
        True shows a bar; a callable is called as ``progress(done, total)``.

    Returns
    -------
    Dataset
        After a kill or Ctrl-C, the same call makes the volumes that are missing.

    Raises
    ------
    ValueError, TypeError
        For an invalid option or spec, before any work, and for volumes of unequal shape in a `.zarr` or `.h5`.
    """
    request = _Request(shape=shape, what=_checked_what(what), scan=checked_options(scan), model=model)
    cases = _sampled(_checked_count(n), sampler, spec, seed)
    store = _store(Path(sink))
    store.accept(request)
    tell = listener(progress)
    try:
        identity = [request.identity(job) for job in cases]
        if not store.is_done(identity):
            left = [job for job, name in zip(cases, identity, strict=True) if not store.has(job[0], name)]
            for done, (number, record) in enumerate(_made(left, request, store, jobs), 1 + len(cases) - len(left)):
                store.finish(number, record, len(cases))
                if tell is not None:
                    tell(done, len(cases), "dataset")
            store.close(identity)
    finally:
        if tell is not None:
            tell.close()
    return Dataset(sink)


class _Request:
    """What is made of every packing."""

    def __init__(self, shape: int | Sequence[int], what: Sequence[str], scan: Mapping[str, Any], *, model: bool) -> None:
        self.shape = shape if isinstance(shape, int) else tuple(int(count) for count in shape)
        self.what = what
        self.scan = scan
        self.model = model

    def identity(self, job: _Job) -> str:
        """Return the hash of all that decides the files of a case."""
        number, spec, seed, values = job
        told = [_VERSION, number, spec.to_dict(), seed, values, self.shape, self.what, self.scan, self.model]
        return hashlib.sha256(json.dumps(told, sort_keys=True, default=_plain).encode()).hexdigest()

    def make(self, job: _Job) -> tuple[Packing, dict[str, NDArray[Any]], dict[str, Any]]:
        """Return a packing, its arrays and its metadata."""
        number, spec, seed, values = job
        packing = pack(spec, seed=seed, threads=1)
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
            "figures": _study_results(packing),
            "spec": packing.spec.to_dict(),
        }
        return packing, arrays, record

    def _array(self, packing: Packing, name: str) -> NDArray[Any]:
        if name == "scan":
            return _scan(packing, shape=self.shape, seed=packing.seed, **self.scan)
        quantity: Any = name
        array: NDArray[Any] = packing.voxelize(what=quantity, shape=self.shape)
        return array


def _made(
    left: Sequence[_Job], request: _Request, store: _Store, jobs: int | None
) -> Iterator[tuple[int, dict[str, Any]]]:
    """Do all cases, some at a time; yield the metadata of each as it ends."""

    def one(job: _Job) -> tuple[int, dict[str, Any]]:
        try:
            packing, arrays, record = request.make(job)
            record["files"] = store.write(job[0], arrays)
            if request.model:
                store.write_model(job[0], packing)
        except (ValueError, TypeError) as error:
            message = f"volume {job[0]}: {error}"
            raise type(error)(message) from error
        return job[0], record

    workers = jobs or os.cpu_count() or 1
    with ThreadPoolExecutor(workers) as pool:
        waiting = iter(left)
        running: set[Future[tuple[int, dict[str, Any]]]] = set()
        while True:
            # A few ahead: the results of a thousand cases would otherwise wait in memory.
            running |= {pool.submit(one, job) for _, job in zip(range(2 * workers - len(running)), waiting)}
            if not running:
                return
            ended, running = wait(running, return_when=FIRST_COMPLETED)
            for future in ended:
                try:
                    yield future.result()
                except BaseException:
                    pool.shutdown(wait=False, cancel_futures=True)
                    raise


class _Store:
    """A folder with a file for each array of a case, and `cases/NUMBER.json`."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def accept(self, request: _Request) -> None:
        """Make the folder; refuse a request that it cannot hold."""
        for folder in (_CASES, *(["models"] if request.model else [])):
            (self.root / folder).mkdir(parents=True, exist_ok=True)

    def is_done(self, _identity: Sequence[str]) -> bool:
        """Whether nothing is left, without a look at each case."""
        return False

    def has(self, number: int, identity: str) -> bool:
        """Whether a case is there with whole files."""
        record = self._record(number)
        return (
            record is not None
            and record["hash"] == identity
            and all(_length(self.root / name) == length for name, length in record["files"].items())
        )

    def write(self, number: int, arrays: Mapping[str, NDArray[Any]]) -> dict[str, int]:
        """Write the arrays of a case; return its files and their lengths."""
        name = f"{number:06}.npz"
        with _whole(self.root / name) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL) as file:
            for key, array in arrays.items():
                with file.open(f"{key}.npy", "w", force_zip64=True) as member:
                    np.lib.format.write_array(member, array, allow_pickle=False)
        return {name: (self.root / name).stat().st_size}

    def write_model(self, number: int, packing: Packing) -> None:
        packing.write(self.root / "models" / f"{number:06}.json.gz")

    def finish(self, number: int, record: dict[str, Any], _count: int) -> None:
        """Write the metadata of a case, after its arrays."""
        text = json.dumps(record, indent=1, default=_plain)
        with _whole(self.root / _CASES / f"{number:06}.json") as part:
            part.write_text(text + "\n", encoding="utf-8")

    def close(self, identity: Sequence[str]) -> None:
        """Write what describes all cases, and remove cases beyond the last."""
        for path in (self.root / _CASES).glob("*.json"):
            if int(path.stem) >= len(identity):
                path.unlink()

    def cases(self) -> list[dict[str, Any]]:
        """Read the metadata of all cases."""
        paths = sorted((self.root / _CASES).glob("*.json"))
        if not paths:
            message = f"{self.root} has no data set: mc.dataset(..., sink={str(self.root)!r}) makes one"
            raise FileNotFoundError(message)
        return [json.loads(path.read_text(encoding="utf-8")) for path in paths]

    def read(self, case: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """Read the arrays of a case."""
        with np.load(self.root / f"{case['number']:06}.npz") as file:
            return dict(file)

    def _record(self, number: int) -> dict[str, Any] | None:
        try:
            record: dict[str, Any] = json.loads((self.root / _CASES / f"{number:06}.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return record


class _Zarr(_Store):
    """A group of zarr, version 2: an array for each quantity, a chunk for each volume."""

    def write(self, number: int, arrays: Mapping[str, NDArray[Any]]) -> dict[str, int]:
        files = {}
        for key, array in arrays.items():
            name = f"{key}/{number}.0.0.0"
            (self.root / key).mkdir(exist_ok=True)
            data = zlib.compress(np.ascontiguousarray(array).data, _LEVEL)
            with _whole(self.root / name) as part:
                part.write_bytes(data)
            files[name] = len(data)
        return files

    def finish(self, number: int, record: dict[str, Any], count: int) -> None:
        """Describe the arrays with the first case; refuse others of another shape."""
        if not (self.root / ".zgroup").exists():
            _write_json(self.root / ".zgroup", {"zarr_format": 2})
        for key, array in record["arrays"].items():
            described = self._described(array, count)
            path = self.root / key / ".zarray"
            there = json.loads(path.read_text(encoding="utf-8")) if path.exists() else None
            if there is None or there["shape"][0] != count:
                there = described
                _write_json(path, described)
            if there != described:
                message = (
                    f"volume {number} has the shape {tuple(array['shape'])} and others {tuple(there['chunks'][1:])}; a folder "
                    "as sink takes volumes of all shapes"
                )
                raise ValueError(message)
        super().finish(number, record, count)

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

    def close(self, identity: Sequence[str]) -> None:
        super().close(identity)
        _write_json(self.root / ".zattrs", {"mesocrete": _VERSION, "cases": f"{_CASES}/NUMBER.json"})
        for path in self.root.glob("*/*.0.0.0"):
            if int(path.name.split(".")[0]) >= len(identity):
                path.unlink()

    def read(self, case: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        return {name: self._read(case["number"], name, array) for name, array in case["arrays"].items()}

    def _read(self, number: int, name: str, array: Mapping[str, Any]) -> NDArray[Any]:
        data = zlib.decompress((self.root / name / f"{number}.0.0.0").read_bytes())
        values: NDArray[Any] = np.frombuffer(bytearray(data), dtype=array["dtype"]).reshape(array["shape"])
        return values


class _Hdf5(_Store):
    """An HDF5 file, made at the end from the chunks of a zarr group beside it, whose compressed bytes it takes as they are."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._parts = _Zarr(path.with_name(f".{path.name}.parts"))

    def accept(self, request: _Request) -> None:
        if request.model:
            message = "model is True; an .h5 holds no models: take a folder or a .zarr as sink"
            raise ValueError(message)
        _h5py()

    def is_done(self, identity: Sequence[str]) -> bool:
        if self.root.exists():
            with _h5py().File(self.root, "r") as file:
                if file.attrs.get("identity") == _digest(identity):
                    return True
        (self._parts.root / _CASES).mkdir(parents=True, exist_ok=True)
        return False

    def has(self, number: int, identity: str) -> bool:
        return self._parts.has(number, identity)

    def write(self, number: int, arrays: Mapping[str, NDArray[Any]]) -> dict[str, int]:
        return self._parts.write(number, arrays)

    def finish(self, number: int, record: dict[str, Any], count: int) -> None:
        self._parts.finish(number, record, count)

    def close(self, identity: Sequence[str]) -> None:
        """Put the chunks together, the whole file or none, and remove them."""
        import shutil

        self._parts.close(identity)
        cases = self._parts.cases()
        with _whole(self.root) as part, _h5py().File(part, "w") as file:
            file.attrs["mesocrete"] = _VERSION
            file.attrs["identity"] = _digest(identity)
            file["case"] = [json.dumps(case) for case in cases]
            for name, array in cases[0]["arrays"].items():
                shape, dtype = tuple(array["shape"]), array["dtype"]
                options = {"chunks": (1, *shape), "compression": "gzip", "compression_opts": _LEVEL}
                volumes = file.create_dataset(name, (len(cases), *shape), dtype, **options)
                for case in cases:
                    chunk = (self._parts.root / name / f"{case['number']}.0.0.0").read_bytes()
                    volumes.id.write_direct_chunk((case["number"], 0, 0, 0), chunk)
        shutil.rmtree(self._parts.root)

    def cases(self) -> list[dict[str, Any]]:
        with _h5py().File(self.root, "r") as file:
            return [json.loads(text) for text in file["case"]]

    def read(self, case: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        with _h5py().File(self.root, "r") as file:
            return {name: file[name][case["number"]] for name in case["arrays"]}


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
    """Draw a Latin hypercube of the ranges."""
    over = {key: _range(value) for key, value in ranges.items()}
    draw = {"cases": n, "design": "latin-hypercube", "seed": seed, "over": over}
    plan = _StudyPlan(dict(spec) if isinstance(spec, Mapping) else spec, {}, None, draw)
    own = "seed" in ranges

    def job(number: int) -> _Job:
        values = plan.values(number)
        if not own:
            del values["seed"]
        state = np.random.SeedSequence(seed, spawn_key=(number,))
        return number, plan.spec(number), None if own else _seed(state), values

    return [job(number) for number in range(n)]


def _range(value: Any) -> Any:
    """Return a pair as a range, and a list as it is."""
    if isinstance(value, tuple) and len(value) == 2:
        return {"low": value[0], "high": value[1]}
    return list(value)


def _checked_what(what: Sequence[str]) -> list[str]:
    names = [what] if isinstance(what, str) else list(what)
    wrong = [name for name in names if name not in _QUANTITIES]
    if wrong or not names:
        message = f"what is {what!r}; it must list some of {', '.join(_QUANTITIES)}"
        raise ValueError(message)
    return names


def _checked_count(n: int) -> int:
    if not 1 <= n <= _MOST:
        message = f"n is {n}; it must lie within 1 and {_MOST:,}"
        raise ValueError(message)
    return int(n)


def _row(case: Mapping[str, Any]) -> dict[str, Any]:
    names = ("number", "seed", "voxel_size_mm")
    return {**{name: case[name] for name in names}, **case["values"], **case["figures"]}


def _digest(identity: Sequence[str]) -> str:
    return hashlib.sha256("".join(identity).encode()).hexdigest()


def _length(path: Path) -> int | None:
    return path.stat().st_size if path.is_file() else None


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
