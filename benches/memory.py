"""Peak memory of meshes and tests, per cube of the element size: the constants in crates/meso-mesh/src/options/memory.rs.

    python3 benches/memory.py [COMMAND]     # prints the table of benches/results/memory.csv; Linux only, about five minutes
    python3 benches/memory.py --quick       # elements three times as large, which say nothing of large meshes

A cube of 50 mm at 30 % is meshed into a deck, or tested for a moment. The command's own 8 MB are left out.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SPEC = 'seed = 1\nfraction = 0.3\n[specimen]\nkind = "cube"\nside_mm = 50.0\n'
SIDE_MM, OWN_BYTES = 50.0, 8e6
MOMENT = ["--strain", "1e-5", "--duration", "2e-5", "--frames", "1"]
MESHES = [
    ("voxel --itz none", 0.5),
    ("voxel --itz none", 0.35),
    ("voxel --thin-itz", 0.5),
    ("voxel --itz none --subsamples 3", 0.5),
    ("voxel --itz cohesive", 0.5),
    ("lattice --itz none", 1.0),
    ("lattice --itz none", 0.8),
    ("lattice", 1.0),
    ("lattice --itz cohesive", 1.0),
    ("lattice --analysis compression", 1.0),
    ("lattice --fit plain --itz none", 0.8),
    ("lattice --order 2 --itz none", 1.0),
]
TESTS = [("voxel", 1.0), ("voxel", 0.8), ("lattice", 1.6), ("lattice", 1.2)]


def peak(command: list[str], folder: str) -> tuple[int, str]:
    """Run a command; its peak memory in bytes, and the words that it printed."""
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    words = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, words
    return usage.ru_maxrss * 1024, words


def main() -> None:
    """Measure and print."""
    given = [word for word in sys.argv[1:] if word != "--quick"]
    command = str(Path(given[0]).resolve()) if given else shutil.which("mesocrete") or "mesocrete"
    coarser = 3.0 if "--quick" in sys.argv else 1.0
    print("work,options,element_size_mm,elements,peak_mb,bytes_per_cube")
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "s.toml").write_text(SPEC, encoding="utf-8")
        peak([command, "pack", "s.toml", "-qo", "s.json"], folder)
        runs = [("mesh", ["-fo", "x.inp", "--accept-phase-error"], *mesh) for mesh in MESHES]
        runs += [("solve", ["-fo", "out", *MOMENT], *test) for test in TESTS]
        for work, flags, options, fine in runs:
            size = coarser * fine
            method = ["--element-size-mm", str(size), "--method", *options.split()]
            taken, words = peak([command, work, "s.json", *flags, *method], folder)
            elements = re.search(r"([\d,]+) elements", words)
            count = elements[1].replace(",", "") if elements else ""
            print(f"{work},{options},{size},{count},{taken / 1e6:.1f},{(taken - OWN_BYTES) / (SIDE_MM / size) ** 3:.0f}", flush=True)


if __name__ == "__main__":
    main()
