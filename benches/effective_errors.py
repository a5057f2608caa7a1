"""Whether the stated errors of effective properties contain the value at a quarter of the size, and keep Reuss and Voigt.

Random packings and label volumes in small boxes: values of 0 to 10,000, an ITZ up to 100 times the mortar. Each case is one row per axis
in `benches/results/effective_errors.csv`; cases that have rows are not run again. A packing has the default size, an eighth of its
smallest grain, and a quarter of that; a label volume has its voxels, and each of them cut in 64.

    python benches/effective_errors.py --command target/release/mesocrete [--cases 200]
    python benches/effective_errors.py --quick    two cases, kept nowhere
"""

import argparse
import csv
import json
import random
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from origin import origin

RESULTS = Path(__file__).parent / "results" / "effective_errors.csv"
HEAD = ["case", "kind", "values", "axis", "value", "error", "at_a_quarter", "reuss", "voigt", "contained", "within", "machine", "date", "commit"]


def run(*command):
    found = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if found.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))}: {found.stderr.strip()}")


def effective(command, folder, model, *options):
    out = folder / "out"
    run(command, "effective", model, "--phases", folder / "phases.toml", "-o", out, "-f", "-q", "--no-fields", *options)
    return json.loads((out / "effective.json").read_text())


def packing(draw, number, command, folder):
    d_min = draw.choice([4, 5])
    size = [round(draw.uniform(2.2, 3.6) * d_min, 1) for _ in range(3)]
    periodic = [axis for axis in "xyz" if draw.random() < 0.5]
    itz = sorted(draw.choice([0.05, 0.1, 0.2, 0.3, 0.5]) for _ in range(2))
    aggregate = draw.choice([0, 0, 10 ** draw.uniform(-4, 0), 10 ** draw.uniform(0, 4), 10 ** draw.uniform(-1, 1)])
    of_itz = draw.choice([1.0, 10 ** draw.uniform(-2, 0), 10 ** draw.uniform(0, 2), 10 ** draw.uniform(1, 2), 0.0])
    shape, fraction = draw.choice(["polyhedron", "ellipsoid", "sphere"]), draw.choice([0.15, 0.25, 0.35, 0.4])
    (folder / "spec.toml").write_text(
        f"seed = {number}\nfraction = {fraction}\n"
        f'specimen = {{ kind = "box", size_mm = {size}, periodic = {json.dumps(periodic)} }}\n'
        f"grading = {{ d_min_mm = {d_min}, d_max_mm = {d_min * draw.choice([1.6, 2.0])} }}\n"
        f'shape = {{ kind = "{shape}" }}\nitz = {{ thickness_mm = {itz} }}\n'
    )
    (folder / "phases.toml").write_text(f"[diffusivity]\nmortar = 1.0\naggregate = {aggregate}\nitz = {of_itz}\n")
    run(command, "pack", folder / "spec.toml", "-o", folder / "model.json", "-f", "-q", "--time-limit", 30)
    found = [
        effective(command, folder, folder / "model.json", "--voxel-size-mm", d_min / 8 / parts) for parts in (1, 4)
    ]
    return shape, f"{aggregate:.3g} {of_itz:.3g}", found


def labels(draw, number, command, folder):
    noise = np.random.default_rng(number)
    count = draw.choice([10, 12, 16])
    kind = draw.choice(["voxels", "blobs", "balls", "layers"])
    volume = noise.random((count,) * 3)
    if kind == "blobs":
        for axis in range(3):
            volume = (np.roll(volume, 1, axis) + 2 * volume + np.roll(volume, -1, axis)) / 4
    if kind == "balls":
        places = np.indices((count,) * 3)
        centres = noise.random((4, 3)) * count
        volume = np.min([np.sqrt(sum((places[a] - c[a]) ** 2 for a in range(3))) for c in centres], axis=0)
    if kind == "layers":
        volume = np.broadcast_to(noise.random(count)[:, None, None], volume.shape)
    shares = sorted(noise.random(2))
    numbers = np.digitize(volume, np.quantile(volume, shares)).astype(np.uint8)
    values = [1.0] + [draw.choice([0, 10 ** draw.uniform(-4, 4), 10 ** draw.uniform(-1, 1)]) for _ in range(2)]
    draw.shuffle(values)
    (folder / "phases.toml").write_text("[diffusivity]\n" + "".join(f"{n} = {value}\n" for n, value in enumerate(values)))
    options = ["--periodic", "xyz"] if draw.random() < 0.5 else []
    found = []
    for parts in (1, 4):
        cut = np.kron(numbers, np.ones((parts,) * 3, np.uint8))
        np.save(folder / "labels.npy", cut)
        found.append(effective(command, folder, folder / "labels.npy", "--voxel-size-mm", 1 / parts, *options))
    return kind, " ".join(f"{value:.3g}" for value in values), found


def rows(number, kind, values, found, about):
    coarse, fine = found
    bounds = coarse["bounds"]
    for axis in range(3):
        value, error, quarter = coarse["tensor"][axis][axis], coarse["error"][axis][axis], fine["tensor"][axis][axis]
        rounding = 1e-6 * abs(quarter)
        within = bounds["reuss"] * (1 - 1e-12) <= value <= bounds["voigt"] * (1 + 1e-12)
        contained = abs(value - quarter) <= error + rounding
        yield [number, kind, values, "xyz"[axis], value, error, quarter, bounds["reuss"], bounds["voigt"], contained, within, *about]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--command", default="mesocrete")
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--from", dest="first", type=int, default=0)
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--quick", action="store_true", help="two cases, kept nowhere")
    given = parser.parse_args()
    if given.quick:
        with tempfile.TemporaryDirectory() as folder:
            return measure(given.command, range(2), Path(folder) / "quick.csv")
    return measure(given.command, range(given.first, given.cases), given.results)


def measure(command, numbers, results):
    about = origin().split(",")
    done = set()
    if results.exists():
        with results.open(newline="") as file:
            done = {int(row["case"]) for row in csv.DictReader(file)}
    else:
        results.write_text(",".join(HEAD) + "\n")
    for number in numbers:
        if number in done:
            continue
        draw = random.Random(number)
        with tempfile.TemporaryDirectory() as folder:
            case = packing if number % 2 == 0 else labels
            try:
                found = case(draw, number, command, Path(folder))
            except RuntimeError as error:
                print(f"{number}: {error}")
                continue
        with results.open("a", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(rows(number, *found, about))
    with results.open(newline="") as file:
        all_rows = list(csv.DictReader(file))
    for kind in sorted({row["kind"] for row in all_rows}) + ["all"]:
        own = [row for row in all_rows if kind in (row["kind"], "all")]
        shares = [sum(row[key] == "True" for row in own) for key in ("contained", "within")]
        print(f"{kind}: {len(own)} axes, {shares[0]} contain the value at a quarter, {shares[1]} within Reuss and Voigt")


if __name__ == "__main__":
    main()
