"""The pace of the plates: steps over those that were planned, and what the pace costs beside twice the duration at steady speed.

Each case is a default test in a fitted lattice, on one thread, and a row of `benches/results/servo_pace.csv`; rows of this rule are kept.

    python benches/pace.py --command target/release/mesocrete
    python benches/pace.py --quick     one case of coarse elements, kept nowhere
"""

import argparse
import csv
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from origin import RESULTS, origin

TABLE = RESULTS / "servo_pace.csv"
RULE = "fall 2, least 0.1, mean over 0.002 of the way"
CUBE, CYLINDER = 'kind = "cube", side_mm = {0}', 'kind = "cylinder", diameter_mm = {0}, height_mm = {0}'
SPEC = "seed = {seed}\nfraction = 0.4\nspecimen = {{ {specimen} }}\ngrading = {{ d_min_mm = 5.0, d_max_mm = {largest} }}\nplacement = {{ min_gap_mm = 1.0 }}\n"
# Name of the specimen and its test, shape, size in mm, largest grain in mm, seed, element in mm, flags.
CASES = [
    ("cube of 36 mm, compression, friction 0.1, seed 1", CUBE, 36, 16, 1, 3, []),
    ("cube of 50 mm, compression, friction 0.1, seed 1", CUBE, 50, 20, 1, 2.5, []),
    ("cube of 60 mm, compression, friction 0.1, seed 2", CUBE, 60, 20, 2, 2.5, []),
    ("cube of 100 mm, compression, friction 0.1, seed 1", CUBE, 100, 20, 1, 3, []),
    ("cube of 36 mm, compression, friction 0.6, seed 1", CUBE, 36, 16, 1, 3, ["--friction", 0.6]),
    ("cube of 36 mm, tension, seed 1", CUBE, 36, 16, 1, 3, ["--test", "tension"]),
    ("cube of 50 mm, tension, seed 1", CUBE, 50, 20, 1, 2.5, ["--test", "tension"]),
    ("cylinder of 36 mm, splitting, seed 1", CYLINDER, 36, 16, 1, 3, ["--test", "splitting"]),
    ("cube of 36 mm, cyclic, seed 1", CUBE, 36, 16, 1, 3, ["--test", "cyclic"]),
]


def tested(command, folder, element, flags):
    """Figures of a test, and its curve as rows of strain and stress."""
    words = [command, "solve", folder / "spec.toml", "-o", folder / "out", "--element-size-mm", element, *flags]
    words += ["--frames", 0, "--threads", 1, "--accept-phase-error", "-f", "-q"]
    subprocess.run([str(word) for word in words], check=True, capture_output=True)
    curve = np.genfromtxt(folder / "out" / "curve.csv", delimiter=",", names=True)
    return json.loads((folder / "out" / "result.json").read_text()), np.column_stack([curve["strain"], curve["stress_mpa"]])


def beside(curve, truth):
    """Errors of a curve: energy beyond the peak in %, and stress, rms in MPa. Curves that turn have neither."""
    if (np.diff(curve[:, 0]) < -1e-7).any() or (np.diff(truth[:, 0]) < -1e-7).any():
        return ["", ""]
    end = min(curve[-1, 0], truth[-1, 0])
    at = np.linspace(0.0, end, 4001)
    stress, true = (np.interp(at, np.maximum.accumulate(own[:, 0]), own[:, 1]) for own in (curve, truth))
    energy, whole = (own[own.argmax() :].sum() for own in (stress, true))
    return [f"{100.0 * (energy / whole - 1.0):.2f}", f"{np.sqrt(np.mean((stress - true) ** 2)):.3f}"]


def measured(command, folder, element, flags):
    """Columns of a case from the element's size to the kinetic energy."""
    result, curve = tested(command, folder, element, flags)
    duration = 2.0 * result["steps_planned"] * result["time_step_s"]
    reference, truth = tested(command, folder, element, [*flags, "--control", "steady", "--duration", duration])
    peak = 100.0 * (result["peak_mpa"] / reference["peak_mpa"] - 1.0)
    kinetic = f"{result['kinetic_over_internal_to_half_peak']:.5f}"
    return [element, f"{result['steps'] / result['steps_planned']:.3f}", f"{peak:.2f}", *beside(curve, truth), kinetic]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--command", default="mesocrete")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    kept = list(csv.reader(TABLE.open()))
    done = {(row[0], row[2], row[3], row[-2]) for row in kept}
    today = origin().split(",")
    with tempfile.TemporaryDirectory() as folder:
        for name, shape, size, largest, seed, element, flags in CASES:
            if (RULE, name, str(element), today[1]) in done and not options.quick:
                continue
            spec = SPEC.format(seed=seed, specimen=shape.format(size), largest=largest)
            (Path(folder) / "spec.toml").write_text(spec)
            if options.quick:
                return print(measured(options.command, Path(folder), 6, flags))
            row = [RULE, "meso", name, *measured(options.command, Path(folder), element, flags), *today]
            with TABLE.open("a", newline="") as table:
                csv.writer(table, lineterminator="\n").writerow(row)
            print(row, flush=True)
    return None


if __name__ == "__main__":
    main()
