#!/usr/bin/env python3
"""Packs every spec of the benchmark with mesocrete, checks it, and writes its rows: python3 benchmark/run.py [results.csv]

Seconds are processor time of the packing alone, megabytes the peak of the whole process.
"""

import csv
import platform
import resource
import sys
import time
import tomllib
from pathlib import Path

import check

import mesocrete as mc

HERE = Path(__file__).resolve().parent
COLUMNS = ["program", "version", *check.COLUMNS, "cpu_seconds", "peak_mb", "machine"]


def row(path: Path) -> dict[str, object]:
    """Pack one spec and check it."""
    begun = time.process_time()
    packing = mc.pack(path, seed=1)
    seconds = time.process_time() - begun
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    found = check.check(tomllib.loads(path.read_text(encoding="utf-8")), [grain.vertices for grain in packing.aggregates])
    cost = {"cpu_seconds": round(seconds, 1), "peak_mb": round(megabytes), "machine": machine()}
    return {"program": "mesocrete", "version": mc.__version__, "spec": path.stem} | found | cost


def machine() -> str:
    """Name the processor."""
    cpus = Path("/proc/cpuinfo")
    names = [line.partition(":")[2].strip() for line in cpus.read_text().splitlines() if line.startswith("model name")] if cpus.exists() else []
    return names[0] if names else platform.processor()


def main() -> None:
    """Write a row for every spec."""
    with Path(sys.argv[1] if len(sys.argv) > 1 else HERE / "results.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for path in sorted((HERE / "specs").glob("*.toml")):
            writer.writerow(row(path))
            file.flush()


if __name__ == "__main__":
    main()
