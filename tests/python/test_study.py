"""Studies: every combination once, resumed after kills, on any executor, with the same bytes."""

import concurrent.futures
import csv
import importlib.util
import json
import math
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import mesocrete as mc

# Packs in some ten milliseconds.
TINY = {"specimen": {"kind": "cube", "side_mm": 30.0}, "fraction": 0.25, "grading": {"d_max_mm": 10.0}}
OVER = {"seed": range(1, 4), "fraction": [0.2, 0.3]}


def largest(packing: mc.Packing) -> dict[str, float]:
    """Return what a study of these tests asks of a packing."""
    return {"largest_mm3": packing.aggregates[0].volume}


def written(packing: mc.Packing, folder: Path) -> int:
    """Write a file of its own, and return a bare number."""
    packing.write(folder / "grains.csv")
    return len(packing)


def failing(packing: mc.Packing) -> dict[str, float]:
    """Fail for one of the seeds."""
    if packing.seed == 2:
        message = "seed two is not liked"
        raise ArithmeticError(message)
    return {"seed_squared": float(packing.seed**2)}


def slow(packing: mc.Packing) -> dict[str, float]:
    """Leave time to kill a worker."""
    time.sleep(0.3)
    return largest(packing)


def contents(out: Path) -> dict[str, bytes]:
    """Read every file of a study, but for the temporary ones that a `kill -9` may leave (docs/guarantees.md)."""
    files = [path for path in sorted(out.rglob("*")) if path.is_file() and not path.name.startswith(".mesocrete-")]
    return {str(path.relative_to(out)): path.read_bytes() for path in files}


def test_every_combination_has_a_folder_and_a_row(tmp_path):
    study = mc.study(TINY, OVER, then=largest, out=tmp_path / "s")
    assert len(study) == 6
    table = study.table()
    assert table["seed"].tolist() == [1, 1, 2, 2, 3, 3]
    assert table["fraction"].tolist() == [0.2, 0.3] * 3
    assert set(table["status"]) == {"done"}
    for i, folder in enumerate(study.folders):
        own = mc.pack(TINY, seed=int(table["seed"][i]), fraction=float(table["fraction"][i]))
        assert mc.load(folder / "model.json") == own == study.packing(i)
        assert table["largest_mm3"][i] == own.aggregates[0].volume
    assert "6 done, 0 failed" in repr(study)


def test_without_a_function_the_reports_figures_are_the_table(tmp_path):
    table = mc.study(TINY, {"seed": [5]}, out=tmp_path / "s").table()
    report = mc.pack(TINY, seed=5).report()
    for key in ("aggregates", "discarded", "stop_reason", "fraction"):
        assert table[key][0] == report[key]


def test_csv_is_the_table(tmp_path):
    study = mc.study(TINY, OVER, then=failing, out=tmp_path / "s")
    table = study.table()
    with (tmp_path / "s" / "table.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(table) == list(rows[0])
    assert len(rows) == 6
    assert [int(row["seed"]) for row in rows] == table["seed"].tolist()
    squares = [1.0, 1.0, None, None, 9.0, 9.0]
    assert [float(row["seed_squared"]) if row["seed_squared"] else None for row in rows] == squares
    assert rows[2]["error"] == "ArithmeticError: seed two is not liked"
    assert [row["status"] for row in rows] == table["status"].tolist()


def test_all_types_survive_a_frame_and_its_parquet(tmp_path):
    pytest.importorskip("pyarrow")
    pandas = pytest.importorskip("pandas")

    def mixed(packing):
        n = packing.seed
        return {"flag": n % 3 == 0, "text": f"grün {n}", "n": n, "x": n / 7, "rare": 1.5 if n % 2 else math.nan}

    tiny = {"specimen": {"kind": "cube", "side_mm": 12.0}, "fraction": 0.1, "grading": {"d_max_mm": 6.0}}
    study = mc.study(tiny, {"seed": range(1, 41)}, then=mixed, out=tmp_path / "s")
    study.table("pandas").to_parquet(tmp_path / "table.parquet")
    read = pandas.read_parquet(tmp_path / "table.parquet")
    seeds = range(1, 41)
    assert read["flag"].tolist() == [n % 3 == 0 for n in seeds]
    assert read["text"].tolist() == [f"grün {n}" for n in seeds]
    assert read["x"].tolist() == [n / 7 for n in seeds]
    assert read["rare"].isna().tolist() == [n % 2 == 0 for n in seeds]
    assert study.table()["n"].tolist() == read["n"].tolist() == list(seeds)


def test_a_bar_names_the_cases_and_is_plain_lines_in_a_pipe(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("mesocrete._study._MINUTE", 0.0)
    mc.study(TINY, {"seed": [1, 2]}, out=tmp_path / "s", progress=True)
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(" after ")[0].split(" a minute")[0].rpartition(", ")[0] for line in lines[1:]] == [
        f"study: {n} of 2, 0 failed, {2 - n} running" for n in (1, 2)
    ]
    assert lines[0].startswith("study: 0 of 2, 0 failed, 1 running: 0 % after ") and ", 0 min left: 100 % after" in lines[2]


def test_failures_are_kept_with_their_message_and_done_again_on_request(tmp_path):
    study = mc.study(TINY, {"seed": [1, 2, 3]}, then=failing, out=tmp_path / "s")
    assert isinstance(study, mc.Study) and "2 done, 1 failed" in repr(study)
    assert list(study.failures.values()) == ["ArithmeticError: seed two is not liked"]
    assert np.isnan(study.table()["seed_squared"][1])
    calls = []
    mc.study(TINY, {"seed": [1, 2, 3]}, then=failing, out=tmp_path / "s", progress=lambda *n: calls.append(n))
    assert calls == [(3, 3)]
    calls.clear()
    again = {"retry_failed": True, "progress": lambda *n: calls.append(n)}
    mc.study(TINY, {"seed": [1, 2, 3]}, then=failing, out=tmp_path / "s", **again)
    assert calls == [(2, 3), (3, 3)]


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_the_tables_are_frames_by_a_word_and_keep_what_is_missing(tmp_path, library):
    module = pytest.importorskip(library)
    study = mc.study(TINY, {"seed": [1, 2, 3]}, then=failing, out=tmp_path / "s")
    frame, groups = study.table(library), study.ensemble(frame=library)
    assert isinstance(frame, module.DataFrame) and isinstance(groups, module.DataFrame)
    assert list(frame.columns) == list(study.table()) and list(groups.columns) == list(study.ensemble())
    missing = getattr(frame["seed_squared"], "isna" if library == "pandas" else "is_null")()
    assert missing.to_list() == [False, True, False]
    assert frame["seed"].to_list() == [1, 2, 3] and frame["status"].to_list() == ["done", "failed", "done"]
    assert groups["mean"].to_list() == [5.0]


def test_the_table_is_a_data_set_along_the_cases_with_units(tmp_path):
    pytest.importorskip("xarray")
    work = lambda packing: {"peak_mpa": 30.0 + packing.seed, "work_n_per_mm": 0.1, "n": len(packing)}
    study = mc.study(TINY, {"seed": [1, 2, 3], "specimen.side_mm": [20, 25]}, then=work, out=tmp_path / "s")
    data = study.table("xarray")
    units = {name: of.attrs.get("units") for name, of in data.variables.items()}
    expected = {"peak_mpa": "MPa", "work_n_per_mm": "N/mm", "specimen.side_mm": "mm", "n": None, "seed": None}
    assert expected.items() <= units.items()
    grid = data.set_index(case=study.keys).unstack("case")
    assert grid["peak_mpa"].dims == ("seed", "specimen.side_mm") and grid["peak_mpa"].values.tolist() == [[31, 31], [32, 32], [33, 33]]
    assert study.ensemble(frame="xarray")["mean"].dims == ("row",)
    if importlib.util.find_spec("pandas"):
        assert study.table("pandas").attrs["units"]["peak_mpa"] == "MPa"


def test_a_missing_library_is_reported_before_a_study_reads_its_folder(tmp_path, monkeypatch):
    study = mc.study(TINY, {"seed": [1]}, then=largest, out=tmp_path / "s")
    (tmp_path / "s" / "table.csv").unlink()
    monkeypatch.setitem(sys.modules, "polars", None)
    with pytest.raises(ImportError, match="polars is not installed; get it with: pip install polars"):
        study.table("polars")
    assert not (tmp_path / "s" / "table.csv").exists()


def test_done_cases_are_skipped_and_longer_axes_add_to_them(tmp_path):
    first = mc.study(TINY, {"seed": [1, 2]}, then=largest, out=tmp_path / "s")
    times = [(folder / "model.json").stat().st_mtime_ns for folder in first.folders]
    longer = mc.study(TINY, {"seed": [1, 2, 3]}, then=largest, out=tmp_path / "s")
    assert [(folder / "model.json").stat().st_mtime_ns for folder in longer.folders[:2]] == times
    assert len(longer.table()["seed"]) == 3


def test_a_torn_case_is_done_again(tmp_path):
    study = mc.study(TINY, {"seed": [1, 2]}, then=largest, out=tmp_path / "s")
    whole = contents(study.out)
    (study.folders[0] / "model.json").write_bytes(b"{")
    (study.folders[1] / "case.json").write_bytes(b'{"case": ')
    (study.folders[1] / ".mesocrete-x.tmp").write_bytes(b"half")
    mc.study(TINY, {"seed": [1, 2]}, then=largest, out=tmp_path / "s")
    assert contents(study.out) == whole


def test_another_function_takes_the_packings_that_are_there(tmp_path):
    study = mc.study(TINY, {"seed": [1, 2]}, then=largest, out=tmp_path / "s")
    times = [(folder / "model.json").stat().st_mtime_ns for folder in study.folders]
    other = mc.study(TINY, {"seed": [1, 2]}, then=written, out=tmp_path / "s")
    assert [(folder / "model.json").stat().st_mtime_ns for folder in other.folders] == times
    assert other.table()["value"].tolist() == [len(other.packing(0)), len(other.packing(1))]
    assert all((folder / "grains.csv").is_file() for folder in other.folders)


def test_ensembles_are_statistics_over_the_seeds(tmp_path):
    stats = pytest.importorskip("scipy.stats")
    study = mc.study(TINY, {"seed": range(1, 9), "fraction": [0.2, 0.3]}, then=largest, out=tmp_path / "s")
    table, groups = study.table(), study.ensemble()
    assert groups["fraction"].tolist() == [0.2, 0.3]
    for i, fraction in enumerate(groups["fraction"]):
        sample = table["largest_mm3"][table["fraction"] == fraction]
        assert groups["figure"][i] == "largest_mm3"
        assert groups["mean"][i] == pytest.approx(sample.mean(), rel=1e-12)
        assert groups["std"][i] == pytest.approx(sample.std(ddof=1), rel=1e-9)
        low, high = stats.t.interval(0.95, 7, sample.mean(), stats.sem(sample))
        assert (groups["low"][i], groups["high"][i]) == pytest.approx((low, high), rel=1e-9)
        n = int(groups["needed"][i])
        half = [stats.t.ppf(0.975, m - 1) * sample.std(ddof=1) / math.sqrt(m) for m in (n - 1, n)]
        assert half[1] <= 0.01 * sample.mean() < half[0]
    with pytest.raises(ValueError, match='replicate is "sed"; it must be an axis of the study: seed, fraction'):
        study.ensemble("sed")


def test_threads_and_processes_give_the_same_bytes(tmp_path):
    here = contents(mc.study(TINY, OVER, then=largest, out=tmp_path / "here").out)
    with concurrent.futures.ThreadPoolExecutor(2) as executor:
        threads = mc.study(TINY, OVER, then=largest, out=tmp_path / "threads", executor=executor)
    assert contents(threads.out) == here
    spawn = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=spawn) as executor:
        processes = mc.study(TINY, OVER, then=largest, out=tmp_path / "processes", executor=executor)
    assert contents(processes.out) == here


def test_a_dask_cluster_that_loses_a_worker_gives_the_same_bytes(tmp_path):
    distributed = pytest.importorskip("distributed")
    here = contents(mc.study(TINY, {"seed": range(8)}, then=slow, out=tmp_path / "here").out)
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        killed = []

        def kill(over: int, _: int) -> None:
            if over == 2 and not killed:
                killed.append(next(iter(cluster.workers.values())).pid)
                os.kill(killed[0], signal.SIGKILL)

        out = tmp_path / "dask"
        there = mc.study(TINY, {"seed": range(8)}, then=slow, out=out, executor=client, progress=kill)
    assert killed, "a worker was killed"
    assert not there.failures
    assert contents(there.out) == here


SCRIPT = """
import sys, time
import mesocrete as mc
spec = {"specimen": {"kind": "cube", "side_mm": 30.0}, "fraction": 0.25, "grading": {"d_max_mm": 10.0}}
mc.study(spec, {"seed": range(12)}, out=sys.argv[1])
"""


@pytest.mark.skipif(os.name == "nt", reason="kills by signal")
def test_a_killed_study_loses_the_case_in_hand_at_most(tmp_path):
    """`kill -9` at random moments; the seed of this test's own draws is fixed."""
    draw, out = random.Random(19), tmp_path / "s"
    kills, before = 0, 0
    for _ in range(20):
        process = subprocess.Popen([sys.executable, "-c", SCRIPT, str(out)])
        try:
            process.wait(0.05 + 0.3 * draw.random())
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            kills += 1
        records = list(out.glob("*/case.json"))
        for record in records:
            assert json.loads(record.read_text(encoding="utf-8"))["status"] == "done"
        # Folders without a record: the one in hand of each kill. The next run takes other cases first.
        assert sum(not (folder / "case.json").exists() for folder in out.glob("seed-*")) <= kills
        assert len(records) >= before, "what is done stays done"
        before = len(records)
    assert kills >= 2
    subprocess.run([sys.executable, "-c", SCRIPT, str(out)], check=True)
    straight = mc.study(TINY, {"seed": range(12)}, out=tmp_path / "t")
    assert contents(out) == contents(straight.out)


def test_wrong_studies_are_refused_before_the_work(tmp_path):
    out = tmp_path / "s"
    with pytest.raises(ValueError, match=r"case seed = 1, fraction = 1.5: fraction is 1.5"):
        mc.study(TINY, {"seed": [1], "fraction": [0.2, 1.5]}, out=out)
    with pytest.raises(ValueError, match=r"over.seed has no values"):
        mc.study(TINY, {"seed": []}, out=out)
    with pytest.raises(TypeError, match=r'over\["seed"\] is 3; give an iterable of values'):
        mc.study(TINY, {"seed": 3}, out=out)
    with pytest.raises(TypeError, match="executor is of type int"):
        mc.study(TINY, {"seed": [1]}, out=out, executor=3)
    with pytest.raises(TypeError, match="progress is of type int"):
        mc.study(TINY, {"seed": [1]}, out=out, progress=3)
    with pytest.raises(TypeError, match=r"then is of type str; it must be a callable that takes \(packing\)"):
        mc.study(TINY, {"seed": [1]}, then="volume", out=out)
    with concurrent.futures.ProcessPoolExecutor(1) as pool:
        with pytest.raises(TypeError, match="then cannot be sent to another process"):
            mc.study(TINY, {"seed": [1]}, then=lambda _: 1, out=out, executor=pool)
    assert not list(out.glob("seed-*"))


def test_a_spec_and_the_toml_of_it_are_the_same_study(tmp_path):
    (tmp_path / "SPEC.toml").write_text(mc.Spec(**TINY).to_toml(), encoding="utf-8")
    over = {"grading.d_max_mm": [8.0, 10.0]}
    specs = [TINY, mc.Spec(**TINY)]
    folders = [mc.study(spec, over, out=tmp_path / "s").folders for spec in specs]
    assert folders[0] == folders[1]


@pytest.mark.slow
def test_sixty_packings_cost_a_tenth_more_than_packing_and_saving_them(tmp_path):
    """CPU seconds of this process, in turns: wall time waits for others, and a busy machine slows both alike."""
    spec = {"specimen": {"kind": "cube", "side_mm": 60.0}}
    costs = {"alone": 0.0, "study": 0.0}
    for seed in range(20):
        over = {"seed": [seed], "fraction": [0.3, 0.4, 0.5]}
        start = time.process_time()
        for fraction in over["fraction"]:
            mc.pack(spec, seed=seed, fraction=fraction).write(tmp_path / f"{seed}-{fraction}.json")
        between = time.process_time()
        mc.study(spec, over, out=tmp_path / f"study-{seed}")
        costs["alone"] += between - start
        costs["study"] += time.process_time() - between
    assert costs["study"] <= 1.1 * costs["alone"], costs
