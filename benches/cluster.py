#!/usr/bin/env python3
"""Arrays and executors under kills: the bytes of the serial study, nothing done twice. Appends to benches/results/cluster.csv.

    python3 benches/cluster.py --command target/debug/mesocrete array     # 40 tasks, 10 of them killed, submitted again
    python3 benches/cluster.py plan                                       # 100,000 cases: memory, time to the first record
    python3 benches/cluster.py overhead                                   # time a case beside the same loop by hand
    python3 benches/cluster.py dask                                       # two workers, each killed twice
    python3 benches/cluster.py dataset                                    # volumes by one job, by two processes and by two workers of dask
    python3 benches/cluster.py --quick                                    # few cases, and no rows

The tasks of the array are started as Slurm starts them, by a stand-in of SLURM_ARRAY_TASK_ID, some at a time.
"""

import argparse
import concurrent.futures
import csv
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from origin import origin

RESULTS = Path(__file__).parent / "results" / "cluster.csv"
STUDY = """[spec]
fraction = 0.2
specimen = { kind = 'cube', side_mm = 20 }
grading = { d_min_mm = 5, d_max_mm = 8 }
[over]
seed = { from = 1, to = CASES }
"""
TINY = {"specimen": {"kind": "cube", "side_mm": 20.0}, "fraction": 0.15, "grading": {"d_min_mm": 5, "d_max_mm": 8}}


def save(what: str, **figures: object) -> None:
    """Append one row a figure, unless the run is a quick one."""
    for name, value in figures.items():
        print(what, name, value)
    if QUICK:
        return
    is_new = not RESULTS.exists()
    with RESULTS.open("a", encoding="utf-8") as file:
        file.write("what,figure,value,machine,date,commit\n" if is_new else "")
        file.writelines(f"{what},{name},{value},{origin()}\n" for name, value in figures.items())


def contents(out: Path) -> dict[str, bytes]:
    """Read all files but those that a killed process leaves."""
    files = [path for path in sorted(out.rglob("*")) if path.is_file() and not path.name.startswith(".mesocrete-")]
    return {str(path.relative_to(out)): path.read_bytes() for path in files}


def array(command: str, seed: int) -> None:
    """Start 40 tasks, kill 10 at random moments, start all again, collect."""
    draw, tasks = random.Random(seed), 4 if QUICK else 40
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        cases = 12 if QUICK else 120
        (place / "STUDY.toml").write_text(STUDY.replace("CASES", str(cases)), encoding="utf-8")
        subprocess.run([command, "study", "STUDY.toml", "-q", "-o", "serial"], cwd=place, check=True)
        script = subprocess.run(
            [command, "study", "STUDY.toml", "-o", "array", f"--slurm={tasks}"], cwd=place, check=True, capture_output=True, text=True
        ).stdout
        (place / "study.sbatch").write_text(script.replace("exec mesocrete", f"exec {command}"), encoding="utf-8")
        doomed = set(draw.sample(range(1, tasks + 1), tasks // 4))

        def task(number: int, is_doomed: bool) -> int:
            process = subprocess.Popen(
                ["bash", "study.sbatch"],
                cwd=place,
                env={**os.environ, "SLURM_ARRAY_TASK_ID": str(number)},
                stderr=subprocess.DEVNULL,
            )
            if is_doomed:
                time.sleep(draw.uniform(0.0, 0.1))
                process.send_signal(signal.SIGKILL)
            return process.wait()

        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            first = list(pool.map(lambda number: task(number, number in doomed), range(1, tasks + 1)))
            before = {path: path.stat().st_mtime_ns for path in place.glob("array/*/case.json")}
            again = list(pool.map(lambda number: task(number, False), range(1, tasks + 1)))
        twice = sum(path.stat().st_mtime_ns != time_ns for path, time_ns in before.items())
        collected = subprocess.run([command, "study", "STUDY.toml", "-q", "-o", "array", "--collect"], cwd=place, check=False)
        equal = contents(place / "array") == contents(place / "serial")
        save(
            "array", tasks=tasks, killed=sum(code < 0 for code in first), cases=cases, left_after_kills=cases - len(before),
            failed_tasks_again=sum(code != 0 for code in again), done_twice=twice, collect_exit=collected.returncode,
            bytes_equal=equal,
        )  # fmt: skip


def plan() -> None:
    """Plan 100,000 cases and begin them."""
    import mesocrete as mc

    class Begun(Exception):
        """The first record is there."""

    folder = tempfile.mkdtemp()
    cases = 1000 if QUICK else 100_000
    started, cpu, taken = time.monotonic(), time.process_time(), []

    def stop(over: int, _: int) -> None:
        if over:
            taken.extend((time.monotonic() - started, time.process_time() - cpu))
            raise Begun

    try:
        with concurrent.futures.ThreadPoolExecutor(2) as executor:
            mc.study(TINY, {"seed": range(cases)}, out=folder, executor=executor, progress=stop)
    except Begun:
        pass
    save(
        "plan", cases=cases, first_record_s=round(taken[0], 2), first_record_cpu_s=round(taken[1], 2),
        memory_mb=round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3),
    )  # fmt: skip
    shutil.rmtree(folder)


def nothing(packing: object) -> dict[str, float]:
    """Do no work."""
    return {"n": float(len(packing))}  # type: ignore[arg-type]


def by_hand(place: str, seed: int) -> None:
    """Pack, save, and call the function, as a loop of one's own does."""
    import json

    import mesocrete as mc

    folder = Path(place) / str(seed)
    folder.mkdir()
    packing = mc.pack(TINY, seed=seed)
    packing.write(folder / "model.json")
    (folder / "case.json").write_text(json.dumps(nothing(packing)), encoding="utf-8")


def seconds_of(work: object) -> float:
    """CPU time of a call with a pool of two processes, and of these."""

    def spent() -> float:
        own, workers = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        return own.ru_utime + own.ru_stime + workers.ru_utime + workers.ru_stime

    before = spent()
    with concurrent.futures.ProcessPoolExecutor(2) as executor:
        work(executor)  # type: ignore[operator]
    return spent() - before


def overhead() -> None:
    """Compare 300 empty cases on two processes with the same loop by hand: CPU time, which other work does not change."""
    import mesocrete as mc

    cases, rounds = 10 if QUICK else 300, []
    for _ in range(1 if QUICK else 3):
        with tempfile.TemporaryDirectory() as place:
            (Path(place) / "h").mkdir()
            hand = seconds_of(lambda executor: list(executor.map(by_hand, [f"{place}/h"] * cases, range(cases))))
            over = {"seed": range(cases)}
            study = seconds_of(lambda executor: mc.study(TINY, over, then=nothing, out=f"{place}/s", executor=executor))
            rounds.append((study, hand))
            print(rounds[-1], file=sys.stderr)
    study, hand = (min(times) for times in zip(*rounds))
    save("overhead", cases=cases, study_cpu_ms=round(1e3 * study / cases, 2), by_hand_cpu_ms=round(1e3 * hand / cases, 2))


def dask() -> None:
    """Two workers, each of which is killed twice."""
    from distributed import Client, LocalCluster

    import mesocrete as mc

    with tempfile.TemporaryDirectory() as place:
        here = mc.study(TINY, {"seed": range(60)}, then=nothing, out=Path(place) / "here")
        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            killed = []

            def kill(over: int, _: int) -> None:
                if over in (6, 12, 18, 24):
                    killed.append(list(cluster.workers.values())[len(killed) % 2].pid)
                    os.kill(killed[-1], signal.SIGKILL)

            there = mc.study(TINY, {"seed": range(60)}, then=nothing, out=Path(place) / "there", executor=client, progress=kill)
        equal = contents(here.out) == contents(there.out)
        save("dask", cases=60, killed=len(set(killed)), failed=len(there.failures), bytes_equal=equal)


def dataset() -> None:
    """Volumes of 64^3 by one job, by a pool of two processes, by two workers of dask: wall time on quiet cores, equal bytes."""
    from distributed import Client, LocalCluster

    import mesocrete as mc

    drawn = {"fraction": (0.2, 0.4)}
    for name, count, spec in [("usual", 4 if QUICK else 100, {}), ("tiny", 4 if QUICK else 1000, TINY)]:
        with (
            tempfile.TemporaryDirectory() as place,
            concurrent.futures.ProcessPoolExecutor(2) as pool,
            LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
            Client(cluster) as client,
        ):
            seconds = {}
            for way, how in {"one_job": {"jobs": 1}, "pool": {"executor": pool}, "dask": {"executor": client}}.items():
                asked = {**how, "spec": spec, "shape": 64, "seed": 1}
                mc.dataset(8, drawn, sink=f"{place}/warm-{way}.zarr", **asked)
                begun = time.monotonic()
                mc.dataset(count, drawn, sink=f"{place}/{way}.zarr", **asked)
                seconds[f"{way}_s"] = round(time.monotonic() - begun, 1)
            equal = len({str(contents(Path(place) / f"{way}.zarr")) for way in ("one_job", "pool", "dask")}) == 1
        save(f"dataset of {name}", volumes=count, **seconds, bytes_equal=equal)


QUICK = "--quick" in sys.argv

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="*", default=["array", "plan", "overhead"], help="array, plan, overhead, dask, dataset")
    parser.add_argument("--command", default="mesocrete")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--quick", action="store_true")
    asked = parser.parse_args()
    command = str(Path(asked.command).absolute()) if "/" in asked.command else asked.command
    runs = {"array": lambda: array(command, asked.seed), "plan": plan, "overhead": overhead, "dask": dask, "dataset": dataset}
    for what in asked.what:
        runs[what]()
