"""Run time of a test against its error: element size, duration, time step with the mass that it adds, smoothing and control.

One cube is crushed with one knob turned at a time, on one thread, and compared with the finest of all: the smallest elements in half of
their time step. Each case is a row of `benches/results/solver_error.csv`; cases that have rows are not run again.
`docs/images/solver-error.png` shows both errors over the processor time, and the Pareto front.

    python benches/solver_error.py
    python benches/solver_error.py --quick     two cases of coarse elements, kept nowhere
    python benches/solver_error.py --draw      needs matplotlib
"""

import argparse
import csv
import json
import resource
import subprocess
import tempfile
from pathlib import Path

from origin import RESULTS, origin

TABLE = RESULTS / "solver_error.csv"
PICTURE = Path(__file__).parents[1] / "docs" / "images" / "solver-error.png"
HEAD = ["case", "knob", "element_mm", "cpu_s", "steps", "added_mass_percent", "kinetic_percent", "peak_mpa", "to_half_mm", "energy_n_per_mm", "machine", "date", "commit"]
SPEC = """seed = 1
fraction = 0.4
specimen = { kind = "cube", side_mm = 36.0 }
grading = { d_min_mm = 5.0, d_max_mm = 16.0 }
placement = { min_gap_mm = 1.0 }
"""
# Strain at the end, and duration of the test at it by default, s (docs/tests.md: 24 us for each mm and 0.5 %).
STRAIN, DURATION = 0.012, 24e-6 * 36.0 * 0.012 / 0.005
# Time step for each mm of an element by default, s.
STEP = 1e-7
REFERENCE = "reference"


def cases():
    """Name, knob, element size in mm and flags of every case, the most important first."""
    for size in (3.0, 4.0, 2.4, 5.0, 2.0):
        yield f"size {size}", "element size", size, []
    for share in (0.25, 0.5, 2.0, 4.0):
        yield f"duration x {share}", "duration", 3.0, ["--duration", repr(share * DURATION)]
    for share in (0.25, 0.5, 0.75, 1.25, 1.5, 2.0):
        yield f"step x {share}", "time step", 3.0, ["--time-step", repr(share * STEP * 3.0)]
    for size in (4.0, 3.0, 2.4):
        yield f"unsmoothed {size}", "no smoothing", size, ["--smoothing", "none"]
    for size in (4.0, 3.0, 2.4):
        yield f"voxels {size}", "voxels", size, ["--method", "voxel"]
    yield "steady", "control", 3.0, ["--control", "steady"]
    # The row of size 3.0 was measured with gradients of 32 bits, at the commit that it names.
    yield "gradients of 16 bits", "gradients", 3.0, []
    for size, share in ((4.0, 0.5), (5.0, 0.5), (2.4, 0.5)):
        yield f"size {size}; duration x {share}", "both", size, ["--duration", repr(share * DURATION)]
    yield "size 1.6", "element size", 1.6, []
    yield REFERENCE, "reference", 1.6, ["--time-step", repr(0.5 * STEP * 1.6)]


def measured(command, folder, size, flags):
    """Run a case; its figures in the order of the table."""
    (folder / "spec.toml").write_text(SPEC)
    words = [command, "solve", folder / "spec.toml", "-o", folder / "out", "--element-size-mm", size, "--strain", STRAIN]
    words += ["--frames", 0, "--threads", 1, "--accept-phase-error", "-f", "-q", *flags]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    found = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = json.loads((folder / "out" / "result.json").read_text())
    if found.returncode and not result.get("errors"):
        raise RuntimeError(found.stderr)
    cpu = after.ru_utime - before.ru_utime
    kinetic = 100.0 * result["kinetic_over_internal_to_half_peak"]
    figures = [cpu, result["steps"], result["added_mass_percent"], kinetic, result["peak_mpa"]]
    return [f"{value:.5g}" for value in [*figures, result["displacement_to_half_mm"] or float("nan"), result["energy_beyond_peak_n_per_mm"]]]


def rows():
    """Every row of the table, by its case."""
    return {row["case"]: row for row in csv.DictReader(TABLE.open())} if TABLE.exists() else {}


def front(points):
    """The points that no other one beats in both time and error."""
    best = []
    for time, error in sorted(points):
        if not best or error < best[-1][1]:
            best.append((time, error))
    return best


def error_of(row, truth, key):
    """Error of a figure, %; an error below 0.01 % is drawn there."""
    return max(100.0 * abs(float(row[key]) / float(truth[key]) - 1.0), 0.01)


def draw():
    """Draw both errors over the time."""
    import matplotlib.pyplot as plt

    table = rows()
    truth = table.pop(REFERENCE)
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
    for axis, (key, label) in zip(axes, (("peak_mpa", "peak"), ("to_half_mm", "displacement from the peak to half of it")), strict=True):
        points = {}
        for row in table.values():
            points.setdefault(row["knob"], []).append((float(row["cpu_s"]), error_of(row, truth, key)))
        for knob, own in points.items():
            axis.plot(*zip(*sorted(own), strict=True), "o", label=knob)
        found = [point for own in points.values() for point in own]
        axis.step(*zip(*front(found), strict=True), where="post", color="0.4", lw=1, label="Pareto front")
        default = table["size 3.0"]
        axis.plot(float(default["cpu_s"]), error_of(default, truth, key), "s", ms=12, mfc="none", mec="k", label="defaults at 3 mm")
        axis.set(xscale="log", yscale="log", xlabel="processor time, s", ylabel=f"error of the {label}, %")
        axis.grid(alpha=0.3)
    axes[0].legend(fontsize=8)
    figure.savefig(PICTURE, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--command", default="mesocrete")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--draw", action="store_true")
    options = parser.parse_args()
    if options.draw:
        return draw()
    with tempfile.TemporaryDirectory() as folder:
        if options.quick:
            for flags in ([], ["--smoothing", "none"]):
                print(measured(options.command, Path(folder), 6.0, [*flags, "--duration", "2e-4"]))
            return None
        for name, knob, size, flags in cases():
            if name in rows():
                continue
            row = [name, knob, size, *measured(options.command, Path(folder), size, flags), *origin().split(",")]
            is_new = not TABLE.exists()
            with TABLE.open("a", newline="") as table:
                writer = csv.writer(table, lineterminator="\n")
                writer.writerows([HEAD, row] if is_new else [row])
            print(row, flush=True)


if __name__ == "__main__":
    main()
