#!/usr/bin/env python3
"""Strength of concrete over the rate of strain: what the law adds, and what the inertia of the specimen does.

    python3 benches/rates.py --program target/release/mesocrete
    python3 benches/rates.py --quick        one packing and one rate

Cubes with 40 % of grains of 5 to 16 mm are pulled and pressed between two plates in real time, with and without the
`rate_effect` of the law, and pulled from a uniform rate of strain, without a wave from the plates (rates.csv). They are
pressed between two bars with other ramps, frictions and pressures (hopkinson.csv, with `rate_effect`). The strength at rest
is that of the quasi-static test of the same mesh. The fib curve is that of fib Model Code 2010, 5.1.11, both branches. Rows
that stand in the tables are kept; rates.svg draws the first.
"""

import argparse
import csv
import itertools
import json
import statistics
import subprocess
import sys
import tempfile
from collections import defaultdict
from io import StringIO
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from origin import origin  # noqa: E402

# Side and elements of the cubes, mm, load, rates, 1/s, and packings. Slow tests take small cubes: their steps are many.
CASES = [
    (36.0, 3.0, "tension", (1.0, 10.0, 30.0), (1, 2, 3)),
    (36.0, 3.0, "compression", (3.0, 10.0, 30.0, 100.0), (1, 2, 3)),
    (72.0, 3.0, "compression", (100.0,), (1, 2, 3)),
    (72.0, 3.0, "compression", (30.0,), (1,)),
    (24.0, 4.0, "tension", (0.1, 1.0), (1, 2, 3)),
    (24.0, 4.0, "compression", (1.0,), (1, 2, 3)),
    (24.0, 4.0, "tension", (0.01,), (1,)),
    (24.0, 4.0, "compression", (0.1,), (1,)),
    (36.0, 3.0, "uniform tension", (10.0, 30.0, 100.0), (1, 2, 3)),
    (36.0, 3.0, "tension", (1e-5, 1e-3), (1, 2, 3)),
    (36.0, 3.0, "compression", (1e-4, 1e-2), (1, 2, 3)),
]
# Of 3 mm, slower than this, 1/s, and without inertia, these are quasi-static tests with the strengths of the law at that rate.
SLOW = 0.05
# Values of mortar at rest that grow with the rate, the exponent, and the rate at rest, 1/s.
GROWING = {"tensile_mpa": (3.4, 0.018, 1e-6), "compressive_mpa": (33.0, 0.014, 30e-6), "peak_strain": (0.003, 0.014, 30e-6)}
# Strains at which the tests end, beyond the peak.
ENDS = {"tension": 6e-4, "uniform tension": 1e-3, "compression": 6e-3}
FIELDS = ["load", "side_mm", "rate_per_s", "seed", "law", "peak_mpa", "over_rest", "fib", "kinetic_over_internal"]
# A test between bars, and changes of one value; speeds of the striker, m/s.
BARS = {"rise_s": 2e-5, "friction": 0.1, "pressure_mpa": 0.0}
CHANGES = [("rise_s", 1e-5), ("rise_s", 4e-5), ("friction", 0.005), ("friction", 0.4), ("pressure_mpa", 5.0), ("pressure_mpa", 10.0)]
SPEEDS = (6.0, 12.0)
OF_BARS = ["rise_s", "friction", "pressure_mpa", "speed_m_per_s", "seed", "rate_per_s", "peak_mpa", "over_rest", "equilibrium"]


def fib(load: str, rate: float) -> float:
    """Strength over that at rest, both branches."""
    exponent, rest, turn, steep = (0.014, 30e-6, 30.0, 0.012) if load == "compression" else (0.018, 1e-6, 10.0, 0.0062)
    return max(1.0, rate / rest) ** exponent if rate <= turn else steep * (rate / rest) ** (1 / 3)


def spec(side_mm: float, seed: int) -> str:
    """The concrete."""
    return (
        f"seed = {seed}\nfraction = 0.4\n[specimen]\nkind = \"cube\"\nside_mm = {side_mm}\n"
        "[grading]\nd_min_mm = 5.0\nd_max_mm = 16.0\n[placement]\nmin_gap_mm = 1.0\n"
    )


def test(side_mm: float, load: str, rate: float, law: str) -> str:
    """A TEST.toml: two plates move with half of the speed each, after a rise of a twentieth of the time or from the start."""
    pulls, is_uniform = load != "compression", load == "uniform tension"
    if not rate:
        return 'kind = "tension"\n' if pulls else 'kind = "compression"\nfriction = 0.1\n'
    speed = 0.5e-3 * rate * side_mm * (-1 if pulls else 1)
    duration = ENDS[load] / rate
    rows = speed if is_uniform else [[0, 0], [duration / 20, speed], [10 * duration, speed]]
    lines = [f"duration_s = {duration:.6e}", f"rate_effect = {str(law == 'fib').lower()}"]
    lines += ["starts_moving = true"] if is_uniform else []
    for name, side in (("bottom", "z-min"), ("top", "z-max")):
        rule = 'rule = "glued"' if pulls else 'rule = "plate"\nfriction = 0.1'
        drive = f'drive = {{ kind = "speed", speed_m_per_s = {json.dumps(rows)} }}'
        lines.append(f'[[supports]]\nname = "{name}"\non = "{side}"\n{rule}\n{drive}')
    return "\n".join(lines) + "\n"


def at_rest(friction: float, pressure_mpa: float) -> str:
    """A TEST.toml of the same specimen under slow plates."""
    kind = f'kind = "triaxial"\npressure_mpa = {pressure_mpa}' if pressure_mpa else 'kind = "compression"'
    return f"{kind}\nfriction = {friction}\n"


def between_bars(values: dict, speed: float) -> str:
    """A TEST.toml of two bars and a striker of this speed, m/s."""
    lines = [f"{key} = {value}" for key, value in values.items() if value]
    return "\n".join(['kind = "hopkinson"', f"speed_m_per_s = {speed}", "rate_effect = true", *lines]) + "\n"


def grown(rate: float) -> str:
    """A MATERIALS.toml of mortar whose strengths are those at a rate, without further growth."""
    values = [f"{key} = {value * max(rate / rest, 1) ** exponent}" for key, (value, exponent, rest) in GROWING.items()]
    return "\n".join(["[materials.mortar_strength]", *values]) + "\n"


def solve(program: str, case: tuple[float, float, int], text: str, materials: str = "") -> tuple[dict, list[dict[str, float]]]:
    """Result and curve of one test of a side, elements and a seed."""
    side_mm, element_mm, seed = case
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "spec.toml").write_text(spec(side_mm, seed))
        (folder / "test.toml").write_text(text)
        command = [program, "solve", "spec.toml", "-o", "out", "--test", "test.toml", "--force", "--quiet", "--frames", "0"]
        command += ["--element-size-mm", str(element_mm), "--accept-phase-error"]
        if materials:
            (folder / "materials.toml").write_text(materials)
            command += ["--materials", "materials.toml"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        found = folder / "out" / "result.json"
        if not found.exists():
            sys.exit(done.stderr)
        with (folder / "out" / "curve.csv").open() as file:
            curve = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
        return json.loads(found.read_text()), curve


class Table:
    """A table of results that grows row by row, so that whoever stops it loses one row."""

    def __init__(self, path: Path, fields: list[str], keys: int) -> None:
        """Read what is there; the first `keys` of a row say what it is."""
        self.path, self.fields, self.keys = path, fields, keys
        with path.open(newline="") if path.exists() else StringIO() as file:
            self.rows = list(csv.reader(file))[1:]

    def has(self, *key: object) -> bool:
        """Whether a row is there."""
        return any(row[: self.keys] == [str(cell) for cell in key] for row in self.rows)

    def add(self, *row: object) -> None:
        """Add a row, and write all."""
        print(*row, flush=True)
        self.rows.append([str(cell) for cell in (*row, *origin().split(","))])
        with self.path.open("w", newline="") as file:
            csv.writer(file).writerows([[*self.fields, "machine", "date", "commit"], *self.rows])


def of_plates(program: str, table: Table, cases: list) -> None:
    """Strengths between plates over the rate."""
    for side, element, load, rates, seeds in cases:
        for seed in seeds:
            slow = element == 3.0 and max(rates) < SLOW
            laws = ("fib",) if slow else ("at rest", "fib")
            wanted = [(rate, law) for rate in rates for law in laws if not table.has(load, side, rate, seed, law)]
            case = (side, element, seed)
            rest = solve(program, case, test(side, load, 0.0, ""))[0]["peak_mpa"] if wanted else 0.0
            for rate, law in wanted:
                own = (test(side, load, 0.0, ""), grown(rate)) if slow else (test(side, load, rate, law),)
                found = solve(program, case, *own)[0]
                share = found["energies"]["kinetic"] / found["energies"]["internal"]
                peak = found["peak_mpa"]
                table.add(load, side, rate, seed, law, f"{peak:.3f}", f"{peak / rest:.3f}", f"{fib(load, rate):.3f}", f"{share:.2e}")


def of_bars(program: str, table: Table, changes: list, seeds: tuple[int, ...]) -> None:
    """Strengths between bars: what a ramp, friction and pressure change."""
    for seed, change in itertools.product(seeds, [{}, *({key: value} for key, value in changes)]):
        values, case = BARS | change, (36.0, 3.0, seed)
        wanted = [speed for speed in SPEEDS if not table.has(*values.values(), speed, seed)]
        rest = solve(program, case, at_rest(values["friction"], values["pressure_mpa"]))[0]["peak_mpa"] if wanted else 0.0
        for speed in wanted:
            found, curve = solve(program, case, between_bars(values, speed))
            peak = max(curve, key=lambda row: row["stress_mpa"])
            figures = [f"{peak['rate_per_s']:.1f}", f"{found['peak_mpa']:.3f}", f"{found['peak_mpa'] / rest:.3f}"]
            table.add(*values.values(), speed, seed, *figures, f"{peak['equilibrium']:.3f}")


def draw(table: Table, path: Path) -> None:
    """Strength over that at rest over the rate: means of the packings, beside the fib curve."""
    import matplotlib

    matplotlib.use("svg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 3, figsize=(12, 3.6), sharey=True)
    for axes, load in zip(panels, ENDS):
        own = [row for row in table.rows if row[0] == load]
        for number, side in enumerate(sorted({float(row[1]) for row in own})):
            for law, marker, words in (("at rest", "o", "inertia alone"), ("fib", "s", "with rate_effect")):
                some = defaultdict(list)
                for row in own:
                    if float(row[1]) == side and row[4] == law:
                        some[float(row[2])].append(float(row[6]))
                points = sorted((rate, statistics.fmean(found)) for rate, found in some.items())
                fill = "none" if law == "at rest" else f"C{number}"
                axes.plot(*zip(*points), f"C{number}{marker}-", lw=0.8, ms=5, mfc=fill, label=f"{side:g} mm, {words}")
        rates = [10 ** (-5 + k / 50) for k in range(351)]
        axes.plot(rates, [fib(load, rate) for rate in rates], "k-", lw=1, label="fib Model Code 2010")
        axes.set(xscale="log", xlabel="rate of strain, 1/s", title=load)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=7)
    panels[0].set(ylabel="strength over that at rest", ylim=(0.9, 2.2))
    figure.savefig(path, bbox_inches="tight", metadata={"Date": None})
    with path.open("a") as file:
        file.write(f"<!-- {origin()} -->\n")


def main() -> None:
    """Run what is missing, and draw it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(HERE.parent / "target/release/mesocrete"))
    parser.add_argument("--out", type=Path, default=HERE / "results")
    parser.add_argument("--quick", action="store_true", help="one packing and one rate")
    args = parser.parse_args()
    if args.quick:
        with tempfile.TemporaryDirectory() as name:
            of_plates(args.program, Table(Path(name) / "rates.csv", FIELDS, 5), [(24.0, 4.0, "tension", (10.0,), (1,))])
            of_bars(args.program, Table(Path(name) / "hopkinson.csv", OF_BARS, 5), [], (1,))
        return
    plates = Table(args.out / "rates.csv", FIELDS, 5)
    of_plates(args.program, plates, CASES)
    of_bars(args.program, Table(args.out / "hopkinson.csv", OF_BARS, 5), CHANGES, (1, 2, 3))
    draw(plates, args.out / "rates.svg")


if __name__ == "__main__":
    main()
