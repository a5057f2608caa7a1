"""What a data set of a thousand volumes costs: wall and CPU time, disk, and the most memory.

    python3 benches/dataset.py        # with the mesocrete wheel installed; enters benches/results/dataset.csv

One call makes 1,000 cubes of 50 mm, 128 voxels wide, with phases, ids and metadata. Fraction, largest grain and seed differ. The
files go to the temporary folder and are removed. `--quick` makes four volumes and enters nothing.
"""

import os
import resource
import sys
import tempfile
import time
from pathlib import Path

import mesocrete as mc
from origin import RESULTS, origin

TABLE = RESULTS / "dataset.csv"
HEADER = "volumes,voxels,what,sink,wall_s,cpu_s,disk_mb,peak_mb,machine,date,commit"
SPEC = {"specimen": mc.Specimen.cube(50), "grading": mc.Grading.fuller(4, 16)}
RANGES = {"fraction": (0.3, 0.45), "grading.d_max_mm": (12.0, 20.0)}
WHAT = ("phase", "grain")


def cpu_seconds():
    used = os.times()
    return used.user + used.system


def main():
    quick = "--quick" in sys.argv
    volumes, shape = (4, 16) if quick else (1000, 128)
    with tempfile.TemporaryDirectory() as folder:
        start, used = time.perf_counter(), cpu_seconds()
        data = mc.dataset(volumes, RANGES, spec=SPEC, shape=shape, what=WHAT, sink=Path(folder) / "data.zarr", progress=True)
        wall, cpu = time.perf_counter() - start, cpu_seconds() - used
        assert len(data) == volumes and data[volumes - 1]["grain"].shape == (shape,) * 3
        disk = sum(file.stat().st_size for file in Path(folder).rglob("*") if file.is_file()) / 1e6
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
    line = f"{volumes},{shape}^3,{' '.join(WHAT)},zarr,{wall:.0f},{cpu:.0f},{disk:.0f},{peak:.0f},{origin()}"
    print(line)
    if not quick:
        TABLE.write_text(f"{HEADER}\n{line}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
