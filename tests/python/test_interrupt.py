"""Long work beside Python: the GIL is free, Ctrl-C is heard, progress is told."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

import mesocrete as mc

# Far more than a test waits for: the paper's rule never reaches this fraction.
LONG = {
    "specimen": {"kind": "cube", "side_mm": 150.0},
    "fraction": 0.6,
    "placement": {"strategy": "take-and-place", "attempts": 50_000, "time_limit_s": 60.0},
}


class Stop(Exception):
    pass


def interrupted_pack(delay):
    """Packs on one thread until SIGINT comes after `delay` seconds; returns the CPU seconds until Ctrl-C was heard.

    Other work on the machine makes a thread wait, but gives it no CPU time.
    """
    sent = []

    def send():
        sent.append(time.process_time())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(delay, send)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            mc.pack(LONG, threads=1)
        return time.process_time() - sent[0]
    finally:
        timer.cancel()
        timer.join()


@pytest.mark.skipif(os.name == "nt", reason="sends POSIX signals")
@pytest.mark.parametrize("delay", [0.05, 0.3, 1.0])
def test_ctrl_c_is_heard_within_a_fifth_of_a_second(delay):
    assert interrupted_pack(delay) < 0.2
    # and the module goes on working
    assert len(mc.pack({"specimen": {"kind": "cube", "side_mm": 40.0}}, fraction=0.1)) > 0


def test_other_threads_run_while_it_packs():
    def count(seconds):
        counter, end = 0, time.monotonic() + seconds
        while time.monotonic() < end:
            counter += 1
        return counter

    alone = count(0.5)
    stop = threading.Event()
    thread = threading.Thread(target=lambda: mc.pack(LONG, progress=lambda *_: not stop.is_set()))
    thread.start()
    time.sleep(0.1)
    beside = count(0.5)
    stop.set()
    thread.join(timeout=30)
    assert not thread.is_alive()
    # Two workers and a busy machine leave this thread a part of a core; a held GIL would leave it nothing.
    assert beside > 0.05 * alone


def test_progress_is_told_fraction_and_target(small_spec):
    seen = []
    packing = mc.pack(small_spec, progress=lambda fraction, target: seen.append((fraction, target)))
    assert seen, "at least the end is told"
    assert all(0.0 <= fraction <= 1.0 for fraction, _ in seen)
    assert seen[-1][1] == pytest.approx(0.35)
    assert packing.report()["stop_reason"] == "target-reached"


def test_progress_that_says_no_gets_the_best_packing_found():
    start = time.process_time()
    packing = mc.pack(LONG, threads=1, progress=lambda fraction, target: time.process_time() - start < 0.5)
    assert time.process_time() - start < 5.0
    assert packing.report()["stop_reason"] == "interrupted"
    assert 0.0 < packing.fraction < 0.6


@pytest.fixture(scope="module")
def large():
    """A packing whose check takes a quarter of a second."""
    return mc.pack({"specimen": {"kind": "cube", "side_mm": 110.0}, "fraction": 0.45})


# The case: `mesh` computed for eight seconds after its listener had said no, and others went on to their ends.
@pytest.mark.parametrize(
    "work",
    [
        lambda packing, no: packing.mesh(method="lattice", element_size=1.0, itz="none", progress=no),
        lambda packing, no: packing.check(progress=no),
        lambda packing, no: packing.statistics(lines=20_000, progress=no),
        lambda packing, no: packing.effective("diffusivity", voxel_size=0.5, progress=no),
        lambda packing, no: packing.effective("diffusivity", method="lattice", element_size=1.0, progress=no),
        lambda packing, no: mc.from_labels(packing.voxelize(0.4, "grain") + 1, voxel_size=0.4, progress=no),
    ],
)
def test_progress_that_says_no_ends_work_that_has_no_part_to_give(work, large):
    said = []

    def no(done, total):
        said.append(time.process_time())
        return False

    with pytest.raises(RuntimeError, match="stopped: progress returned False"):
        work(large, no)
    assert len(said) == 1
    assert time.process_time() - said[0] < 0.6


def test_an_exception_of_progress_comes_out():
    def progress(fraction, target):
        raise Stop("mine")

    start = time.process_time()
    with pytest.raises(Stop, match="mine"):
        mc.pack(LONG, threads=1, progress=progress)
    assert time.process_time() - start < 5.0


def test_threads_pack_at_once_and_get_the_serial_result(small_spec, packing):
    results = [None] * 4

    def work(slot):
        results[slot] = mc.pack(small_spec, seed=7)

    threads = [threading.Thread(target=work, args=(slot,)) for slot in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(result == packing for result in results)


def pack_in_child(seed):
    packing = mc.pack({"specimen": {"kind": "cube", "side_mm": 60.0}, "fraction": 0.35}, seed=seed)
    return packing, packing.mesh(element_size=6.0).volumes()


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_processes_started_in_every_way_pack_too(method, packing):
    with multiprocessing.get_context(method).Pool(2) as pool:
        (again, volumes), (other, _) = pool.map_async(pack_in_child, [7, 8]).get(timeout=60)
    assert again == packing
    assert other != packing
    assert volumes == packing.mesh(element_size=6.0).volumes()


@pytest.mark.skipif(os.name == "nt", reason="sends POSIX signals")
def test_the_command_ends_with_130_on_ctrl_c_and_keeps_the_best_packing(command, tmp_path):
    (tmp_path / "spec.toml").write_text(mc.Spec(**LONG).to_toml(), encoding="utf-8")
    process = subprocess.Popen([command, "pack", "spec.toml", "-o", "model.json"], cwd=tmp_path, stderr=subprocess.PIPE)
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    # The CPU time from the signal on cannot be asked for from outside: LONG would take a minute.
    message = process.communicate(timeout=30)[1].decode()
    assert process.returncode == 130, message
    assert "panicked" not in message
    assert "Traceback" not in message
    assert sorted(os.listdir(tmp_path)) == ["model.json", "spec.toml"], "no temporary file is left"
    best = mc.load(tmp_path / "model.json")
    assert best.report()["stop_reason"] == "interrupted"
    assert 0.0 < best.fraction < 0.6


# Told to end while it writes, or while it works out what takes seconds; then it ends as scripts do.
ENDS_EARLY = """
import os, signal, sys, threading, time
import mesocrete as mc
mesh = mc.pack({"specimen": {"kind": "cube", "side_mm": 60.0}}, fraction=0.3, seed=1).mesh(element_size=0.5)
sent = []
def send():
    sent.append(time.process_time())
    os.kill(os.getpid(), signal.SIGINT)
timer = threading.Timer(0.1, send)
timer.start()
try:
    WORK
except KeyboardInterrupt:
    print(time.process_time() - sent[0])
"""


def seconds_to_end(work, folder):
    """Runs `work` of a mesh, told to end a tenth of a second later; CPU seconds from then on, and what is left behind."""
    script = ENDS_EARLY.replace("WORK", work)
    done = subprocess.run([sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and done.stdout, f"not told to end in time: {done.stderr}"
    return float(done.stdout), os.listdir(folder)


@pytest.mark.skipif(os.name == "nt", reason="sends POSIX signals")
@pytest.mark.parametrize("name", ["mesh.inp", "mesh.pvtu"])
def test_ctrl_c_while_a_file_is_written_leaves_none_behind(name, tmp_path):
    seconds, left = seconds_to_end(f"mesh.write({name!r})", tmp_path)
    assert seconds < 3.0
    assert left == []


@pytest.mark.skipif(os.name == "nt", reason="sends POSIX signals")
def test_ctrl_c_is_heard_while_a_meshs_quality_is_measured(tmp_path):
    # Again and again: a fast machine is done with one before it is told to end.
    seconds, _ = seconds_to_end("while True: mesh.quality()", tmp_path)
    assert seconds < 0.5


@pytest.mark.skipif(sys.platform != "linux", reason="counts tasks in /proc")
def test_no_worker_is_left_behind(small_spec):
    mc.pack(small_spec)
    deadline = time.monotonic() + 5.0
    while len(os.listdir("/proc/self/task")) > threading.active_count() and time.monotonic() < deadline:
        time.sleep(0.05)
    workers = [open(f"/proc/self/task/{t}/comm").read().strip() for t in os.listdir("/proc/self/task")]
    assert "mesocrete" not in workers
