"""Executors: a few calls in flight, workers that die, workers of another build, the same bytes everywhere."""

import concurrent.futures
import importlib.util
import multiprocessing
import os
import queue
import re
import signal
import subprocess
import threading
import time
import types
from pathlib import Path

import numpy as np
import pytest

import mesocrete as mc
from mesocrete._mesocrete import _Lock

TINY = {"specimen": {"kind": "cube", "side_mm": 20.0}, "fraction": 0.15, "grading": {"d_min_mm": 5, "d_max_mm": 8}}
SPEC = "fraction = 0.15\nspecimen = { kind = 'cube', side_mm = 20 }\ngrading = { d_min_mm = 5, d_max_mm = 8 }\n"
kills = pytest.mark.skipif(os.name == "nt", reason="kills by signal")


def grains(packing: mc.Packing) -> int:
    """Count."""
    return len(packing)


def deadly(packing: mc.Packing, folder: Path) -> int:
    """End every process that works on seed 3, as the system does where memory runs out, unless a file allows it."""
    if packing.seed == 3 and not (folder.parent / "enough-memory").exists():
        os.kill(os.getpid(), signal.SIGKILL)
    return len(packing)


def slow(packing: mc.Packing) -> int:
    """Leave time to kill a worker."""
    time.sleep(0.2)
    return len(packing)


def contents(out: Path) -> dict[str, bytes]:
    """Read every file but those that a killed process leaves."""
    files = [path for path in sorted(out.rglob("*")) if path.is_file() and not path.name.startswith(".mesocrete-")]
    return {str(path.relative_to(out)): path.read_bytes() for path in files}


def spawned(workers: int) -> concurrent.futures.Executor:
    """Return a pool of processes that share nothing with this one."""
    return concurrent.futures.ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))


def pool_of_loky() -> concurrent.futures.Executor:
    """Return joblib's pool."""
    return pytest.importorskip("joblib.externals.loky").get_reusable_executor(2)


@kills
@pytest.mark.parametrize("made", [lambda: spawned(2), pool_of_loky], ids=["processes", "loky"])
def test_a_pool_that_loses_a_worker_goes_on_with_the_same_bytes(made, tmp_path):
    straight = mc.study(TINY, {"seed": range(6)}, then=slow, out=tmp_path / "t")
    with made() as executor:

        def kill(over: int, _: int) -> None:
            if over == 2:
                os.kill(next(iter(executor._processes)), signal.SIGKILL)

        study = mc.study(TINY, {"seed": range(6)}, then=slow, out=tmp_path / "s", executor=executor, progress=kill)
    assert not study.failures
    assert contents(study.out) == contents(straight.out)


@kills
def test_records_in_one_file_survive_a_killed_worker_and_leave_few_files(tmp_path):
    def write(packing: mc.Packing, folder: Path) -> int:
        (folder / "mine").mkdir()
        (folder / "mine" / "notes.txt").write_text("kept by the layout folders only")
        return len(packing)

    over = {"seed": range(12)}
    folders = mc.study(TINY, over, then=grains, version=1, out=tmp_path / "f")
    straight = mc.study(TINY, over, then=write, version=1, out=tmp_path / "t", layout="table")
    with spawned(2) as executor:

        def kill(over: int, _: int) -> None:
            if over == 3:
                os.kill(next(iter(executor._processes)), signal.SIGKILL)

        study = mc.study(TINY, over, then=slow, version=1, out=tmp_path / "s", layout="table", executor=executor, progress=kill)
    assert set(contents(study.out)) == {"records.jsonl", "table.csv", "ensemble.csv"} == {path.name for path in study.out.iterdir()}
    assert (straight.out / "table.csv").read_bytes() != b"" and len(study.results) == 12 and not study.failures
    figures = [study.table(), straight.table(), folders.table()]
    assert all(np.array_equal(table["value"], figures[0]["value"]) for table in figures)
    assert len(study.packing(3)) == study.table()["value"][3]
    with pytest.raises(ValueError, match="leave the layout out, or name another folder"):
        mc.study(TINY, over, then=slow, version=1, out=tmp_path / "s", layout="folders")
    with pytest.raises(ValueError, match='layout is "flat"; it must be|layout is \'flat\'; it must be'):
        mc.study(TINY, over, out=tmp_path / "s", layout="flat")


def check_poison(study: mc.Study, cases: int) -> None:
    """Check that one case has failed, with its reason, and the others are done."""
    assert len(study.results) == cases
    assert list(study.failures.values()) == ["RuntimeError: every process that worked on the case was killed"]


@kills
def test_a_case_that_ends_its_workers_is_recorded_and_the_others_go_on(tmp_path):
    over, out = {"seed": range(8)}, tmp_path / "s"
    with spawned(2) as executor:
        check_poison(mc.study(TINY, over, then=deadly, out=out, executor=executor), 8)
    # The same call leaves it alone, even where it would end this process.
    check_poison(mc.study(TINY, over, then=deadly, out=out), 8)
    (out / "enough-memory").touch()
    study = mc.study(TINY, over, then=deadly, out=out, retry_failed=True)
    assert not study.failures and len(study.results) == 8


@kills
def test_dask_loses_no_more_workers_to_a_case_than_it_allows(tmp_path):
    distributed = pytest.importorskip("distributed")
    dask = pytest.importorskip("dask")
    lost: list[str] = []

    class Losses(distributed.SchedulerPlugin):
        """Counts the workers that the cluster loses."""

        def remove_worker(self, scheduler, worker, **_):
            lost.append(worker)

    # As many workers as the case may end, and one: a machine under load restarts them late.
    with dask.config.set({"distributed.scheduler.allowed-failures": 1}):
        cluster = distributed.LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address=None)
        with cluster, distributed.Client(cluster) as client:
            cluster.scheduler.add_plugin(Losses())
            study = mc.study(TINY, {"seed": range(30)}, then=deadly, out=tmp_path / "s", executor=client)
            assert len(lost) == 2
    check_poison(study, 30)


@kills
@pytest.mark.slow
def test_a_cluster_of_dask_that_drops_its_killed_worker_gets_it_back(tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed")
    dask = pytest.importorskip("dask")
    monkeypatch.setattr("mesocrete._executor._COUNT", 0.2)
    # The case: a loaded machine starts a worker later than dask waits for it, and the study waited without end.
    with dask.config.set({"distributed.deploy.lost-worker-timeout": "10 ms"}):
        with distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:

            def kill(over: int, _: int) -> None:
                if over == 2:
                    os.kill(cluster.workers[0].pid, signal.SIGKILL)

            with distributed.Client(cluster) as client:
                study = mc.study(TINY, {"seed": range(6)}, then=slow, out=tmp_path / "s", executor=client, progress=kill)
    assert len(study.results) == 6 and not study.failures


def test_an_executor_without_workers_asks_for_those_it_had_and_says_once_that_the_cases_wait(monkeypatch):
    from mesocrete import _executor

    asked = []
    cluster = types.SimpleNamespace(worker_spec={0: {}, 1: {}}, workers={1: None}, scale=asked.append)
    nobody = types.SimpleNamespace(submit=None, nthreads=dict, cluster=cluster)
    monkeypatch.setattr(_executor, "_COUNT", 0.01)
    monkeypatch.setattr(_executor, "_NOBODY", 0.05)
    ended = queue.SimpleQueue()
    threading.Timer(0.3, ended.put, ["a future"]).start()
    with pytest.warns(UserWarning, match="dask has no workers: 7 cases wait") as said:
        assert _executor.Workers(nobody)._next(ended, 7) == "a future"
    assert len(said) == 1 and set(asked) == {2}
    cluster._adaptive = "dask counts them itself"
    before = len(asked)
    _executor._revive(cluster)
    assert len(asked) == before


def test_the_command_does_the_study_of_a_file_on_dask(command, tmp_path):
    distributed = pytest.importorskip("distributed")
    spec = f"[spec]\n{SPEC}"
    (tmp_path / "STUDY.toml").write_text(spec + "[over]\nseed = { from = 1, to = 6 }\n")

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([command, "study", "STUDY.toml", *words], cwd=tmp_path, capture_output=True, text=True, timeout=120)

    assert run("-o", "here").returncode == 0
    with distributed.LocalCluster(1, processes=False, protocol="tcp://", threads_per_worker=1, dashboard_address=None) as cluster:
        ended = run("-o", "there", "--dask", cluster.scheduler_address)
        assert ended.returncode == 0 and "6 of 6 cases done, 0 failed" in ended.stderr, ended.stderr
        assert contents(tmp_path / "there") == contents(tmp_path / "here")
        with distributed.Client(cluster) as client:
            study = mc.study(tmp_path / "STUDY.toml", out=tmp_path / "there", executor=client, progress=lambda over, _: assert_over(over))
        assert len(study.results) == 6
    check_memory(distributed, tmp_path)
    (tmp_path / "STUDY.toml").write_text(spec + "fracton = 0.2\n")
    wrong = run("--dask", "tcp://127.0.0.1:1")
    assert wrong.returncode == 2 and "fracton" in wrong.stderr


def check_memory(distributed, place: Path) -> None:
    """Check that a case asks workers that declare their memory for what it is estimated to take."""
    asked = []
    options = {"processes": False, "threads_per_worker": 2, "dashboard_address": None}
    with distributed.LocalCluster(1, resources={"MEMORY": 1e9}, **options) as cluster, distributed.Client(cluster) as client:
        submit = client.submit
        client.submit = lambda *args, **options: (asked.append(options["resources"]["MEMORY"]), submit(*args, **options))[1]
        mesh = {"output": ["m.vtu"], "element_size": 4, "accept_phase_error": True}
        study = mc.study(TINY, {"seed": [1, 2, 3]}, mesh=mesh, out=place / "m", executor=client)
    assert len(study.results) == len(asked) == 3 and not study.failures
    assert all(0 < memory < 1e9 for memory in asked)


def test_a_case_that_no_worker_has_the_memory_for_gets_a_whole_worker():
    from mesocrete import _executor

    assert _executor._needs(5e9, 2e9) == {"resources": {"MEMORY": 2e9}} and _executor._needs(0.0, 2e9) == {}
    workers = lambda *declared: {"workers": {str(i): {"resources": of} for i, of in enumerate(declared)}}
    for declared, most in (((), 0), (({"MEMORY": 1e9}, {"MEMORY": 2e9}), 2e9), (({"MEMORY": 1e9}, {}), 0)):
        client = types.SimpleNamespace(scheduler_info=lambda **_: workers(*declared))
        assert _executor._declared(client) == most
    assert _executor._declared(concurrent.futures.ThreadPoolExecutor(1)) == 0


def test_many_properties_are_those_of_one_call_each(tmp_path):
    packings = [mc.pack(TINY, seed=seed) for seed in range(3)]
    names, seen = [tmp_path / f"{seed}.npy" for seed in range(3)], []
    for name, packing in zip(names, packings):
        np.save(name, packing.voxelize(2.0))
    with spawned(2) as executor:
        found = mc.effective(names, "conductivity", voxel_size=2.0, executor=executor, progress=lambda *told: seen.append(told))
        with pytest.raises(ValueError, match="volume 1: "):
            mc.effective([np.zeros((4, 4, 4), int), np.full((4, 4, 4), 9)], executor=executor)
        with pytest.raises(TypeError, match=re.escape("as in [labels]")):
            mc.effective(np.load(names[0]), executor=executor)
        study = mc.study(TINY, {"seed": range(3)}, effective={"voxel_size": 2}, model="none", out=tmp_path / "s", executor=executor)
    assert seen == [(1, 3), (2, 3), (3, 3)]
    assert found == [mc.effective(np.load(name), "conductivity", voxel_size=2.0) for name in names]
    assert found[0].tensor == found[0]["tensor"]
    table = study.table()["effective.diffusivity.tensor.xx"]
    assert np.array_equal(table, [packing.effective(voxel_size=2).tensor[0][0] for packing in packings])


def fatal(packing):
    """End the worker of one volume."""
    if packing.seed == 7:
        os._exit(9)
    return packing.fraction


def test_volumes_of_one_call_that_ends_its_worker_come_again_one_by_one(tmp_path):
    """A call has two of 40 volumes; the one that is lost is named alone, and all others are recorded."""
    specs = [{**TINY, "seed": seed} for seed in range(40)]
    with spawned(2) as executor, pytest.raises(RuntimeError, match="that worked on volume 7 was killed"):
        mc.dataset(40, specs, shape=4, sink=tmp_path / "d", targets={"f": fatal}, executor=executor)
    done = {int(path.stem) for path in (tmp_path / "d" / "cases").glob("0*.json")}
    assert done == set(range(40)) - {7}


def test_two_threads_of_a_process_do_two_studies_and_one_of_them_a_folder(tmp_path):
    over = {"seed": range(8)}
    right = contents(mc.study(TINY, over, then=slow, version=1, out=tmp_path / "right").out)

    def do(name: str) -> str:
        try:
            mc.study(TINY, over, then=slow, version=1, out=tmp_path / name)
        except BlockingIOError as error:
            return str(error)
        return ""

    with concurrent.futures.ThreadPoolExecutor(2) as threads:
        assert list(threads.map(do, ["a", "b"])) == ["", ""]
        said = sorted(threads.map(do, ["c", "c"]))
    assert said[0] == "" and f"is in use by process {os.getpid()}" in said[1]
    assert contents(tmp_path / "a") == contents(tmp_path / "b") == contents(tmp_path / "c") == right


def assert_over(over: int) -> None:
    """Check that no case is left."""
    assert over == 6


class Counting(concurrent.futures.ThreadPoolExecutor):
    """Counts the calls in flight."""

    def __init__(self, workers: int) -> None:
        super().__init__(workers)
        self.most = self.now = 0
        self._counting = threading.Lock()

    def submit(self, *args, **kwargs):
        """Count, and hand on."""
        with self._counting:
            self.now += 1
            self.most = max(self.most, self.now)
        future = super().submit(*args, **kwargs)
        future.add_done_callback(self._ended)
        return future

    def _ended(self, _):
        with self._counting:
            self.now -= 1


def test_at_most_four_calls_a_worker_are_in_flight_and_each_is_recorded_as_it_ends(tmp_path):
    recorded = []
    with Counting(2) as executor:
        tell = lambda over, _: recorded.append((over, len(list((tmp_path / "s").glob("*/case.json")))))
        mc.study(TINY, {"seed": range(40)}, then=grains, out=tmp_path / "s", executor=executor, progress=tell)
        assert executor.most == 8
        mc.dataset(20, spec=TINY, shape=8, sink=tmp_path / "d", executor=executor)
        assert executor.most == 8
    assert [over for over, _ in recorded] == list(range(41))
    assert all(over <= files <= over + 8 for over, files in recorded)


def test_a_worker_with_another_build_is_refused_by_its_name(tmp_path, monkeypatch):
    monkeypatch.setattr("mesocrete._study._BUILD", ("9.9.9", "linux-x86_64", "0123456789ab"))
    said = rf"process {os.getpid()}, .* has mesocrete {mc.__version__} .* and the driver 9.9.9 linux-x86_64 0123456789ab; install"
    with concurrent.futures.ThreadPoolExecutor(1) as executor, pytest.raises(RuntimeError, match=said):
        mc.study(TINY, {"seed": [1]}, out=tmp_path / "s", executor=executor)
    assert not list((tmp_path / "s").glob("*/case.json"))


def _without_devices():
    os.environ["OCL_ICD_VENDORS"] = "/nowhere"


def test_a_worker_without_the_device_is_refused_by_its_name_and_its_case_stays_open(tmp_path):
    study = {"solve": {"strain": 1e-4, "device": "opencl:0", "accept-phase-error": True, "element-size-mm": 4}, "outputs": ["m.json"]}
    try:
        mc.study(TINY, {"seed": [1]}, out=tmp_path / "here", **study)
    except ValueError as missing:
        pytest.skip(str(missing))
    context = multiprocessing.get_context("spawn")
    said = r"the worker .*, cannot do this test: .*opencl:0"
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context, initializer=_without_devices) as executor:
        with pytest.raises(RuntimeError, match=said):
            mc.study(TINY, {"seed": [1]}, out=tmp_path / "s", executor=executor, **study)
    assert not list((tmp_path / "s").glob("*/case.json"))
    assert mc.study(TINY, {"seed": [1]}, out=tmp_path / "s", **study).failures == {}


def test_libraries_of_two_platforms_may_differ_and_those_of_one_may_not(monkeypatch):
    from mesocrete import _executor

    version, platform, library = _executor.build()
    _executor.require((version, platform, library))
    _executor.require((version, "another-platform", "0123456789ab"))
    with pytest.raises(RuntimeError, match="0123456789ab"):
        _executor.require((version, platform, "0123456789ab"))
    with pytest.raises(RuntimeError, match="8.8.8"):
        _executor.require(("8.8.8", "another-platform", library))


def test_a_folder_that_workers_do_not_share_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("mesocrete._study._run", lambda *_: "done")
    with concurrent.futures.ThreadPoolExecutor(1) as executor:
        with pytest.raises(RuntimeError, match="all workers must see this folder"):
            mc.study(TINY, {"seed": [1]}, out=tmp_path / "s", executor=executor)


@pytest.mark.parametrize("sink", ["volumes", "volumes.zarr", "volumes.h5"])
def test_a_data_set_on_processes_has_the_bytes_of_the_serial_one(sink, tmp_path):
    if sink.endswith("h5") and importlib.util.find_spec("h5py") is None:
        pytest.skip("h5py is not installed")
    asked = {"spec": TINY, "shape": 12, "what": ["phase", "grain"]}
    mc.dataset(6, {"fraction": (0.1, 0.2)}, sink=tmp_path / "serial" / sink, jobs=1, **asked)
    with spawned(2) as executor:
        made = mc.dataset(6, {"fraction": (0.1, 0.2)}, sink=tmp_path / "pool" / sink, executor=executor, **asked)
        with pytest.raises(ValueError, match="jobs is 2, and the executor has its own workers"):
            mc.dataset(6, sink=tmp_path / "x", jobs=2, executor=executor)
    assert np.array_equal(made[5]["phase"], mc.Dataset(tmp_path / "serial" / sink)[5]["phase"])
    assert contents(tmp_path / "pool") == contents(tmp_path / "serial")


@kills
@pytest.mark.parametrize("sink", ["volumes", "volumes.zarr"])
def test_processes_make_parts_of_a_data_set_in_one_sink(command, sink, tmp_path):
    (tmp_path / "SPEC.toml").write_text(SPEC)
    words = [command, "dataset", "SPEC.toml", "-n", "12", "--shape", "10", "--jobs", "1", "-q", "-o"]
    subprocess.run([*words, f"serial/{sink}"], cwd=tmp_path, check=True, timeout=120)

    def start(part: str) -> subprocess.Popen[str]:
        return subprocess.Popen([*words, f"parts/{sink}", "--shard", part], cwd=tmp_path, stderr=subprocess.PIPE, text=True)

    first = [start(f"{part}/3") for part in (1, 2, 3)]
    while not list((tmp_path / "parts" / sink / "cases").glob("0*.json")):
        time.sleep(0.01)
    first[0].kill()
    assert [process.wait(120) for process in first[1:]] == [0, 0]
    # Nobody makes a part that another process makes.
    lock = _Lock(tmp_path / "parts" / sink, None, "1-of-3")
    refused = start("1/3")
    assert "is in use by" in refused.communicate(timeout=120)[1] and refused.returncode == 1
    lock.release()
    again = start("1/3")
    assert again.wait(120) == 0, again.stderr
    assert contents(tmp_path / "parts") == contents(tmp_path / "serial")
    with pytest.raises(ValueError, match=r"shard is \(4, 3\); it must be \(K, N\)"):
        mc.dataset(2, spec=TINY, shape=8, sink=tmp_path / "x", shard=(4, 3))
    with pytest.raises(ValueError, match="an .h5 is one file: take a folder or a .zarr"):
        mc.dataset(2, spec=TINY, shape=8, sink=tmp_path / "x.h5", shard=(1, 3))


def test_one_process_at_a_time_makes_a_data_set_without_parts(tmp_path):
    sink = tmp_path / "volumes.zarr"
    refused = []

    def second(done: int, _: int) -> None:
        if done == 1:
            with pytest.raises(BlockingIOError, match="is in use by process"):
                mc.dataset(3, spec=TINY, shape=8, sink=sink, jobs=1)
            with pytest.raises(BlockingIOError, match="is in use by process"):
                mc.dataset(3, spec=TINY, shape=9, sink=sink, jobs=1, overwrite=True)
            refused.append(done)

    assert len(mc.dataset(3, spec=TINY, shape=8, sink=sink, jobs=1, progress=second)) == 3 and refused == [1]
    assert not list(sink.glob(".mesocrete-*"))


def test_mpi_gives_the_bytes_of_the_serial_study(tmp_path):
    pytest.importorskip("mpi4py", reason="mpi4py is not installed")
    import shutil
    import sys

    if shutil.which("mpirun") is None:
        pytest.skip("mpirun is not installed: apt-get install openmpi-bin")
    script = tmp_path / "study.py"
    script.write_text(
        "import sys\nimport mesocrete as mc\nfrom mpi4py.futures import MPIPoolExecutor\n"
        "if __name__ == '__main__':\n    with MPIPoolExecutor() as executor:\n"
        f"        mc.study({TINY!r}, {{'seed': range(6)}}, out=sys.argv[1], executor=executor)\n"
    )
    words = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "2", sys.executable, "-m", "mpi4py.futures", str(script)]
    subprocess.run([*words, str(tmp_path / "mpi")], check=True, timeout=120, capture_output=True)
    straight = mc.study(TINY, {"seed": range(6)}, out=tmp_path / "t")
    assert contents(tmp_path / "mpi") == contents(straight.out)
