"""What voxel images of the paper's specimen cost: wall and CPU time, and the most memory.

    python3 benches/images.py [PROGRAM]      # enters benches/results/images.csv; PROGRAM is `mesocrete` by default

Every quantity at 0.5 mm (27 million voxels) into a file, and at 0.1 mm (3,375 million) streamed to the null device. Each
image has a process of its own. `--quick` makes images of 15 mm and enters nothing.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from origin import RESULTS, origin

TABLE = RESULTS / "images.csv"
HEADER = "what,voxel_mm,voxels,output,wall_s,cpu_s,peak_mb,machine,date,commit"
QUANTITIES = ["phase", "grain", "share", "distance"]
SIDE_MM = 150.0


def measure(command):
    """Run a command; wall seconds, CPU seconds and peak memory, MB."""
    start = time.perf_counter()
    with open(os.devnull, "wb") as null:
        process = subprocess.Popen(command, stdout=null)
        _, status, used = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(command)} failed")
    return time.perf_counter() - start, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024 / 1e6


def row(program, model, what, size, output):
    name = str(Path(model).parent / "image.npy") if output == "npy" else "-"
    flags = ["--what", what, "--voxel-size-mm", str(size), "--output", name, "--quiet", "--force"]
    wall, cpu, peak = measure([program, "image", model, *flags])
    voxels = round(SIDE_MM / size) ** 3
    return f"{what},{size},{voxels},{output},{wall:.1f},{cpu:.1f},{peak:.0f},{origin()}"


def main():
    quick = "--quick" in sys.argv
    program = next((word for word in sys.argv[1:] if not word.startswith("--")), "mesocrete")
    sizes = [(15.0, "npy"), (15.0, "stream")] if quick else [(0.5, "npy"), (0.1, "stream")]
    lines = [HEADER]
    with tempfile.TemporaryDirectory() as folder:
        model = str(Path(folder) / "model.json")
        subprocess.run([program, "pack", "--quiet", "--output", model], check=True)
        for size, output in sizes:
            for what in QUANTITIES:
                lines.append(row(program, model, what, size, output))
                print(lines[-1], flush=True)
    if not quick:
        TABLE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
