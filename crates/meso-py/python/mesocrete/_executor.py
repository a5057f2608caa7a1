"""Work on the workers of others: `concurrent.futures`, loky, `mpi4py.futures`, `dask.distributed`.

Calls are handed out a few at a time, so that any number of them takes the memory of those few. The engines decide where a call
runs and how often it is tried; a worker with another build of mesocrete is refused.
"""

from __future__ import annotations

import os
import sys
import sysconfig
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, files
from operator import index
from queue import Empty, SimpleQueue
from typing import Any, Protocol

from ._mesocrete import __version__ as _VERSION, _usual_threads

# Calls in flight for each worker: the next ones are there when a call ends.
_AHEAD = 4
# Seconds between two counts of the workers, which come and go on a cluster.
_COUNT = 5.0
# Seconds without any worker until that is said.
_NOBODY = 60.0
# Most threads of a call.
_MOST_THREADS = 1024


class Submitter(Protocol):
    """An `Executor` of `concurrent.futures`, or a client of `dask.distributed`."""

    @property
    def submit(self) -> Callable[..., object]:
        """Submit a call; returns its future."""


class Workers:
    """The workers of an executor."""

    def __init__(self, executor: Any, sent: Callable[..., Any] | None = None) -> None:
        """Refuse what is no executor, and a function `sent` that its processes cannot get."""
        self._given = executor
        self._counted = -_COUNT
        self._most = _AHEAD
        self._is_alone = False
        self._submitted = 0
        self.idle: Callable[[], object] = lambda: None
        self._memory = _declared(executor)
        self._executor: Any = executor
        # dask would take two calls with equal arguments for one.
        self._options = {"pure": False} if hasattr(executor, "get_executor") else {}
        if not hasattr(self._executor, "submit"):
            name = type(executor).__name__
            message = f"executor is of type {name}; it must be a concurrent.futures.Executor or a dask client"
            raise TypeError(message)
        if sent is not None and type(self._executor).__name__ == "ProcessPoolExecutor":
            _check_picklable(sent)

    def done(
        self,
        jobs: deque[Any],
        call: Callable[[Any], tuple[Any, ...]],
        in_hand: Callable[[Any], bool] = lambda _: True,
        memory: Callable[[Any], float] = lambda _: 0.0,
    ) -> Iterator[tuple[Any, Any]]:
        """Take jobs and hand out their calls, a few at a time; yield each with its result as it ends.

        A job whose worker died is tried again as often as the engine does; then its result is None. A pool of processes ends with
        its first loss, and cannot say which job had it: those that were `in_hand` run one by one in a new pool.
        Workers of dask that declare a resource MEMORY get no more at once than the bytes of `memory`.
        """
        needs = lambda job: {**self._options, **(_needs(memory(job), self._memory) if self._memory else {})}
        suspects: deque[Any] = deque()
        while jobs or suspects:
            alone = not jobs
            batch = deque([suspects.popleft()]) if alone else jobs
            is_broken = is_useful = False
            for job, error, result in self._each(batch, call, needs):
                # dask's KilledWorker is no BrokenExecutor: it comes after tries on other workers.
                is_certain = type(error).__name__ == "KilledWorker"
                if error is not None and not is_certain and not isinstance(error, BrokenExecutor):
                    raise error
                is_broken = is_broken or (error is not None and not is_certain)
                if error is not None and not in_hand(job):
                    jobs.append(job)
                    continue
                is_useful = True
                if error is None or alone or is_certain:
                    yield job, result
                else:
                    suspects.append(job)
            if alone:
                jobs.extend(batch)
            if (is_broken or batch) and not (is_useful and self._renew()):
                left = len(jobs) + len(suspects)
                message = f"the executor lost its workers: {left} cases are left; the same call with a new executor does them"
                raise RuntimeError(message)

    def _each(
        self, jobs: deque[Any], call: Callable[[Any], tuple[Any, ...]], needs: Callable[[Any], dict[str, Any]]
    ) -> Iterator[tuple[Any, Any, Any]]:
        """Submit the calls of jobs; yield each with its error or its result. `jobs` keeps what a broken executor does not take."""
        ended: SimpleQueue[Any] = SimpleQueue()
        running: dict[Any, Any] = {}
        try:
            while True:
                while jobs and len(running) < self._window():
                    try:
                        future = self._executor.submit(*call(jobs[0]), **needs(jobs[0]))
                    except BrokenExecutor:
                        break
                    running[future] = jobs.popleft()
                    future.add_done_callback(ended.put)
                self._submitted = len(running)
                if not running:
                    return
                future = self._next(ended, len(jobs) + len(running))
                yield running.pop(future), *self._told(future)
        finally:
            for future in running:
                future.cancel()

    def _next(self, ended: SimpleQueue[Any], left: int) -> Any:
        """Wait for a future that is done; say once that nobody works on those that are left."""
        since = time.monotonic()
        while True:
            try:
                return ended.get(timeout=_COUNT)
            except Empty:
                self.idle()
                if self.count():
                    since = time.monotonic()
                elif not self._is_alone and time.monotonic() - since > _NOBODY:
                    self._is_alone = True
                    warnings.warn(f"dask has no workers: {left} cases wait for new ones, which it takes at any time", stacklevel=2)

    def _told(self, future: Any) -> tuple[Any, Any]:
        """Return the error and the result of a future that is done. A result that dask loses with its worker comes again."""
        while True:
            try:
                # Each question to a future of dask waits for its loop.
                error = None if getattr(future, "status", "") == "finished" else future.exception(timeout=_COUNT)
                return error, None if error is not None else future.result(timeout=_COUNT)
            # Python 3.10 has three of this name.
            except Exception as error:
                if type(error).__name__ != "TimeoutError":
                    raise
                self.count()

    def _renew(self) -> bool:
        """Replace a pool of processes that lost one; False where this cannot be done here."""
        pool, module = self._executor, sys.modules.get(type(self._executor).__module__)
        if type(pool) is ProcessPoolExecutor:
            told: Any = pool
            # Its other processes are being ended, and could still write into folders of cases that are done again.
            told.shutdown(wait=True)
            self._executor = ProcessPoolExecutor(told._max_workers, told._mp_context, told._initializer, told._initargs)
        elif module is not None and hasattr(module, "get_reusable_executor") and not getattr(pool, "_initializer", None):
            self._executor = module.get_reusable_executor(pool._max_workers)
        else:
            return False
        return True

    @property
    def running(self) -> int:
        """Number of the calls that have a worker."""
        return min(self._submitted, self._most // _AHEAD)

    def close(self) -> None:
        """End the processes that were started here."""
        if type(self._executor) is ProcessPoolExecutor and self._executor is not self._given:
            self._executor.shutdown(wait=False, cancel_futures=True)

    def _window(self) -> int:
        now = time.monotonic()
        if now - self._counted >= _COUNT:
            self._counted, self._most = now, _AHEAD * max(self.count(), 1)
        return self._most

    def count(self) -> int:
        """Count the calls that can run at the same time."""
        if hasattr(self._given, "nthreads"):
            _revive(self._given.cluster)
            return int(sum(self._given.nthreads().values()))
        counts = (getattr(self._executor, name, None) for name in ("_max_workers", "num_workers"))
        return int(next((count for count in counts if count), os.cpu_count() or 1))


def _revive(cluster: Any) -> None:
    """Start the workers again that a cluster of dask has dropped: those that were not back some seconds after they were killed."""
    wanted = len(getattr(cluster, "worker_spec", ()))
    if wanted and len(cluster.workers) < wanted and getattr(cluster, "_adaptive", None) is None:
        cluster.scale(wanted)


def _declared(executor: Any) -> float:
    """Return the largest resource MEMORY of the workers of a client of dask, bytes; 0 where one declares none."""
    if not hasattr(executor, "scheduler_info"):
        return 0.0
    workers = executor.scheduler_info(n_workers=-1)["workers"].values()
    declared = [float(worker["resources"].get("MEMORY", 0.0)) for worker in workers]
    return max(declared, default=0.0) if all(declared) else 0.0


def _needs(memory: float, most: float) -> dict[str, Any]:
    """Return the keywords of a call that takes so much memory; one that takes more than any worker has gets a whole worker."""
    return {"resources": {"MEMORY": min(memory, most)}} if memory else {}


def require_threads(number: Any) -> None:
    """Refuse another number of threads than that of a call, before any work."""
    is_whole = hasattr(number, "__index__") and not isinstance(number, bool)
    if number is not None and not (is_whole and 1 <= index(number) <= _MOST_THREADS):
        message = f"threads is {number!r}; it must be an int from 1 to {_MOST_THREADS}"
        raise ValueError(message)


@contextmanager
def on_threads(number: int | None) -> Iterator[None]:
    """Do work on so many threads, unless its calls name a number; None takes all cores."""
    before = _usual_threads(number)
    try:
        yield
    finally:
        _usual_threads(before)


def build() -> tuple[str, str, str]:
    """Return version, platform, and the hash of the installed library, which its features and commit are part of."""
    try:
        found = [str(file.hash.value) for file in files("mesocrete") or [] if "_mesocrete." in file.name and file.hash]
    except PackageNotFoundError:
        found = []
    return _VERSION, sysconfig.get_platform(), found[0][:12] if found else ""


_BUILD = build()


def require(driver: tuple[str, str, str]) -> None:
    """Refuse to work for a driver with another build, whose files could have other bytes.

    Libraries of two platforms differ, and keep the bytes.
    """
    version, platform, library = driver
    if version == _BUILD[0] and (platform != _BUILD[1] or library == _BUILD[2]):
        return
    told = " and ".join(f"{name} {' '.join(one)}" for name, one in ((f"{_where()}, has mesocrete", _BUILD), ("the driver", driver)))
    message = f"{told}; install the driver's on it"
    raise WrongWorkerError(message)


def require_device(find: Callable[[], None]) -> None:
    """Refuse to work without the device that `find` looks for."""
    try:
        find()
    except ValueError as error:
        message = f"{_where()}, cannot do this test: {error}"
        raise WrongWorkerError(message) from error


def _where() -> str:
    import socket

    return f"the worker {socket.gethostname()}, process {os.getpid()}, {sys.executable}"


class WrongWorkerError(RuntimeError):
    """A worker has another build of mesocrete than the driver, or no device of a test."""


def _check_picklable(sent: Callable[..., Any]) -> None:
    import pickle

    try:
        pickle.dumps(sent)
    except Exception as error:
        message = f"then cannot be sent to another process ({error}); define it with def at the top of a module"
        raise TypeError(message) from error
