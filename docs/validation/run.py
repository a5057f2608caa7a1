#!/usr/bin/env python3
"""Runs the tests of docs/measured/validation.md with one set of parameters, one folder a case, and judges them.

    cargo build --release && python3 docs/validation/run.py OUT             everything: a night on two cores
    python3 docs/validation/run.py OUT --jobs 4 --seconds 300               what five minutes give, the most important first
    python3 docs/validation/run.py OUT --side-mm 72                         a quarter of the time
    python3 docs/validation/run.py OUT --shard 3/40                         a task of an array; --judge afterwards
    python3 docs/validation/run.py OUT --judge                              run nothing; judge what is there

A case whose result is there is skipped, so the same command finishes what was begun. Cases run in the order of their
importance. It needs the standard library alone. OUT/cases.csv has the figures of every case, OUT/rows.csv those of every
row; `pictures.py OUT` draws them.
"""

import argparse
import csv
import itertools
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
SMALL_MM, LARGE_MM = 100.0, 150.0


@dataclass(frozen=True)
class Beam:
    """A beam in bending, its grains, and its mortar: modulus and f_t of the test's concrete, as cubes of 36 mm in tension have them."""

    published: str
    span_mm: float
    notch_mm: float
    notch_at_mm: float
    grains_mm: tuple[float, float]
    modulus_mpa: float
    tensile_mpa: float
    fracture_energy_n_per_mm: float

    def materials(self) -> dict:
        """Content of its MATERIALS.toml."""
        strength = {"tensile_mpa": self.tensile_mpa, "fracture_energy_n_per_mm": self.fracture_energy_n_per_mm}
        return {"materials.mortar": {"youngs_modulus_mpa": self.modulus_mpa}, "materials.mortar_strength": strength}


GREGOIRE, GARCIA = (5.0, 10.0), (6.0, 12.0)
BEAMS = {
    "no-notch": ((175.0, 50.0, 50.0), Beam("gregoire_2013_unnotched_d50", 125, 0, 0, GREGOIRE, 29500, 4.03, 0.06)),
    "half-notch": ((175.0, 50.0, 50.0), Beam("gregoire_2013_half_notched_d50", 125, 25, 0, GREGOIRE, 29500, 4.03, 0.06)),
    "mixed-mode": ((250.0, 50.0, 80.0), Beam("garcia_alvarez_2012_mixed_mode_d80", 200, 20, 50, GARCIA, 26000, 3.6, 0.053)),
}


@dataclass(frozen=True)
class Case:
    """One specimen, tested once."""

    group: str
    label: str
    seed: int
    size: tuple[float, ...]
    flags: dict[str, str] = field(default_factory=dict, hash=False)
    fraction: float = 0.4
    element_mm: float = 3.0
    cylinder: bool = False
    kind: str = "compression"
    beam: "Beam | None" = None

    @property
    def name(self) -> str:
        """Name of the folder."""
        return f"{self.group}-{self.label}-{self.seed}"

    @property
    def height(self) -> float:
        """Height along the plates' way, mm."""
        return self.size[-1]

    @property
    def strain(self) -> float:
        """Strain at the end of the test."""
        return float(self.flags["strain"])

    @property
    def cost(self) -> float:
        """Cost over that of a cube of 100 mm in elements of 3 mm that is pressed by 1 %."""
        if self.beam:
            return 0.5 * self.size[0] * self.size[1] * self.height / 4.4e5
        area = self.size[0] ** 2 * 0.785 if self.cylinder else self.size[0] * self.size[1]
        tension = 160 / 24 if self.kind == "tension" else 1.0
        return area * self.height**2 / 1e8 * (3 / self.element_mm) ** 4 * self.strain / 0.01 * tension

    def test(self) -> str:
        """Content of its TEST.toml; specimens that are pressed have a gauge of lateral strain."""
        if self.beam:
            over = "" if self.beam.notch_mm else ", over_mm = 50"
            return f'kind = "bending"\nspan_mm = {self.beam.span_mm}\ngauges = [{{ kind = "crack-mouth", name = "mouth"{over} }}]\n'
        gauge = "" if self.kind == "tension" else '[[gauges]]\nkind = "lateral-strain"\nname = "lateral_strain"\n'
        ratio = f"stress_ratio = {self.label}\n" if self.kind == "biaxial" else ""
        return f'kind = "{self.kind}"\n{ratio}{gauge}'

    def spec(self) -> dict:
        """Fuller from 5 to 16 mm, or a beam's grains, with gaps between bodies."""
        if self.beam and self.beam.notch_mm:
            names = ("length_mm", "width_mm", "depth_mm")
            specimen = {"kind": "notched-prism", **dict(zip(names, self.size)), "notch_width_mm": 2 * self.element_mm}
            specimen |= {"notch_depth_mm": self.beam.notch_mm, "notch_at_mm": self.beam.notch_at_mm}
        elif self.cylinder:
            specimen = {"kind": "cylinder", "diameter_mm": self.size[0], "height_mm": self.height}
        else:
            specimen = {"kind": "box", "size_mm": list(self.size)}
        return {
            "seed": self.seed,
            "fraction": self.fraction,
            "specimen": specimen,
            "grading": dict(zip(("d_min_mm", "d_max_mm"), self.beam.grains_mm if self.beam else (5.0, 16.0))),
            # Bodies of 60 % have no gaps of 1 mm.
            "placement": {"min_gap_mm": 1.0 if self.fraction < 0.5 else 0.2},
        }


def cases(side: float = SMALL_MM) -> list[Case]:
    """Name every case, the most important first."""
    return [case for seed in (1, 2, 3) for case in of_seed(seed, side)]


def of_seed(seed: int, side: float) -> list[Case]:
    """Cases of one seed in the order of importance, with specimens of this width."""
    cube, press = (side, side, side), {"friction": "0.1", "strain": "0.012"}
    found = [
        Case("cube", "0.1", seed, cube, press),
        Case("cube", "0.6", seed, cube, {"friction": "0.6", "strain": "0.012"}),
    ]
    shapes = itertools.product(("0.6", "0.005", "0.13"), (2, 1))
    found += [
        Case("slenderness", f"{mu}-h{n}", seed, (side, n * side), {"friction": mu, "strain": "0.008"}, cylinder=True)
        for mu, n in shapes
    ]
    for percent in (50, 200, 100):
        height = side * percent / 100
        # The same displacement beyond the peak, about 0.8 mm, whatever the height.
        strain = f"{0.003 + 0.8 / height:.4g}"
        found.append(Case("height", f"{percent}", seed, (side, side, height), {"friction": "0.005", "strain": strain}))
    found.append(Case("tension", "72", seed, (min(side, 72.0),) * 3, {"strain": "0.001"}, kind="tension"))
    for name, (size, beam) in BEAMS.items():
        bent = {"strain": "0.002" if name == "no-notch" else "0.0015"}
        found.append(Case("beam", name, seed, size, bent, fraction=0.35, element_mm=4.0, kind="bending", beam=beam))
    for stress_ratio in ("1", "0.52"):
        pressed = {"friction": "0.005", "strain": "0.006"}
        found.append(Case("biaxial", stress_ratio, seed, cube, pressed, kind="biaxial"))
    for size in (2.4, 2.0, 1.6):
        found.append(Case("elements", f"{size}", seed, (50.0,) * 3, press, element_mm=size))
    short = {"friction": "0.1", "strain": "0.004"}
    for fraction in (0.0, 0.2, 0.4, 0.6):
        # No packing is empty: mortar has a few grains.
        packed = max(fraction, 0.002)
        found.append(Case("fraction", f"{fraction}", seed, (min(side, 72.0),) * 3, short, fraction=packed))
    found.append(Case("vonk", "150", seed, (LARGE_MM,) * 3, {"friction": "0.1", "strain": "0.006"}))
    found.append(Case("kupfer", "200", seed, (200.0, 50.0, 200.0), {"friction": "0.005", "strain": "0.007"}))
    return found


def main() -> None:
    """Run cases that have no result, then judge all there are."""
    args = parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    chosen = [case for case in cases(args.side_mm) if case.seed <= args.seeds and (not args.only or case.group in args.only)]
    if args.list:
        for case in chosen:
            print(f"{case.name:28} cost {case.cost:6.2f}  element {case.element_mm} mm")
        return
    if args.shard:
        task, tasks = map(int, args.shard.split("/"))
        if not 1 <= task <= tasks:
            sys.exit(f"--shard is {args.shard}; it must be K/N with K from 1 to N")
        chosen = chosen[task - 1 :: tasks]
    if not args.judge:
        end = time.monotonic() + args.seconds
        with ThreadPoolExecutor(args.jobs) as pool:
            for line in pool.map(lambda case: run(case, args, end), chosen):
                print(line, flush=True)
    if not args.shard:
        judge(chosen, args.out)


def parse_args() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="folder of the results")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="cases at a time (default 1)")
    parser.add_argument("--threads", type=int, metavar="N", help="threads of a case (default: cores over jobs)")
    parser.add_argument("--device", help="device of the solver, as `solve --device` takes it")
    parser.add_argument("--seconds", type=float, default=float("inf"), metavar="S", help="stop all cases after this time")
    parser.add_argument("--only", action="append", default=[], metavar="GROUP", help="one group of cases; repeatable")
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="at most so many seeds (default 3)")
    parser.add_argument("--side-mm", type=float, default=SMALL_MM, metavar="MM", help="width of most specimens (default 100)")
    parser.add_argument("--law", help="another law than the default")
    parser.add_argument("--materials", type=Path, help="other materials than the defaults")
    parser.add_argument("--element-size-mm", type=float, metavar="H", help="coarser or finer elements than a case's")
    parser.add_argument("--shard", metavar="K/N", help="every N-th case from the K-th on, for a task of an array")
    parser.add_argument("--judge", action="store_true", help="run nothing; judge what is there")
    parser.add_argument("--list", action="store_true", help="list the cases and their costs")
    program = HERE.parent.parent / "target/release/mesocrete"
    parser.add_argument("--program", default=str(program), help="the mesocrete to run")
    return parser.parse_args()


def run(case: Case, args: argparse.Namespace, end: float) -> str:
    """Run a case unless its result is there; a case that did not end in time leaves none."""
    folder = args.out / case.name
    if (folder / "result.json").exists():
        return f"{case.name}: kept"
    left = end - time.monotonic()
    if left <= 0:
        return f"{case.name}: no time left"
    folder.mkdir(parents=True, exist_ok=True)
    spec = folder / "spec.toml"
    spec.write_text(toml(case.spec()))
    test = folder / "test.toml"
    test.write_text(case.test())
    element = case.element_mm if args.element_size_mm is None else args.element_size_mm
    threads = args.threads or max(1, (os.cpu_count() or 1) // args.jobs)
    command = [args.program, "solve", str(spec), "-o", str(folder / "test"), "--test", str(test)]
    command += ["--element-size-mm", f"{element}"]
    command += ["--threads", str(threads), "--frames", "0", "--quiet", "--force", "--accept-phase-error"]
    command += [word for key, value in case.flags.items() for word in (f"--{key}", value)]
    materials = args.materials
    if case.beam:
        materials = folder / "materials.toml"
        materials.write_text(toml(case.beam.materials()))
    for flag, value in (("--device", args.device), ("--law", args.law), ("--materials", materials)):
        command += [flag, str(value)] if value else []
    began = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=None if left == float("inf") else left)
    except subprocess.TimeoutExpired:
        return f"{case.name}: stopped after {time.monotonic() - began:.0f} s"
    (folder / "log.txt").write_text(done.stderr)
    if not (folder / "test" / "result.json").exists():
        return f"{case.name}: {done.stderr.strip().splitlines()[-1:]}"
    (folder / "test" / "result.json").rename(folder / "result.json")
    (folder / "test" / "curve.csv").rename(folder / "curve.csv")
    return f"{case.name}: {time.monotonic() - began:.0f} s"


def toml(table: dict) -> str:
    """A table of plain values and tables of them."""
    plain = [f"{key} = {json.dumps(value)}" for key, value in table.items() if not isinstance(value, dict)]
    for name, inner in table.items():
        if isinstance(inner, dict):
            plain += [f"[{name}]", *(f"{key} = {json.dumps(value)}" for key, value in inner.items())]
    return "\n".join(plain) + "\n"


@dataclass
class Curve:
    """A curve and the figures that rows ask for."""

    strain: list[float]
    stress: list[float]
    height: float
    result: dict
    # Load over the opening of the mouth, N and mm, of a beam.
    load: list[float]
    mouth: list[float]

    @property
    def top(self) -> int:
        """Row of the peak."""
        return max(range(len(self.stress)), key=self.stress.__getitem__)

    @property
    def strain_at_peak(self) -> float:
        """Strain at the largest stress."""
        return self.strain[self.top]

    def secant(self) -> float:
        """Modulus to the first point at 30 % of the peak or more, MPa."""
        return next(s / e for e, s in zip(self.strain, self.stress) if s >= 0.3 * self.peak)

    @property
    def peak(self) -> float:
        """Largest stress, MPa."""
        return self.stress[self.top]

    def left_at(self, strain: float) -> float | None:
        """Stress at a strain over the peak."""
        rows = [i for i in range(self.top, len(self.strain)) if self.strain[i] >= strain]
        return self.stress[rows[0]] / self.peak if rows else None

    def beyond_to(self, share: float) -> float | None:
        """Displacement from the peak to a share of it, mm."""
        rows = [i for i in range(self.top, len(self.stress)) if self.stress[i] <= share * self.peak]
        return (self.strain[rows[0]] - self.strain[self.top]) * self.height if rows else None

    def energy(self, share: float) -> float:
        """Energy beyond the peak to a share of it, or to the end, N/mm."""
        total = 0.0
        for i in range(self.top + 1, len(self.stress)):
            total += (self.stress[i] + self.stress[i - 1]) / 2 * (self.strain[i] - self.strain[i - 1]) * self.height
            if self.stress[i] <= share * self.peak:
                break
        return total

    def work(self) -> float:
        """Work of the whole test over its cross-section, N/mm."""
        pieces = zip(itertools.pairwise(self.stress), itertools.pairwise(self.strain))
        return sum((a + b) / 2 * (f - e) for (a, b), (e, f) in pieces) * self.height

    @property
    def mouth_at_peak(self) -> float:
        """Opening of the mouth at the largest load, mm."""
        return max(zip(self.load, self.mouth))[1]

    def load_at(self, mouth: float) -> float | None:
        """Load where the mouth first has an opening."""
        return next((load for load, at in zip(self.load, self.mouth) if at >= mouth), None)

    def opened(self) -> float | None:
        """Work of the load over the opening of the mouth until 0.1 mm, N mm."""
        return under(self.mouth, self.load, 0.1) if self.mouth and max(self.mouth) >= 0.1 else None


def under(at: list[float], load: list[float], end: float) -> float:
    """Area under a load from 0 to an abscissa."""
    points = [(0.0, 0.0), *zip(at, load)]
    return sum((f + g) / 2 * (b - a) for (a, f), (b, g) in itertools.pairwise(points) if b <= end)


def envelope(name: str) -> dict[str, list[float]]:
    """Columns of a published beam; rows without a lower bound end it."""
    with (HERE / f"{name}.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {key: [float(row[key]) for row in rows if row["load_min_n"]] for key in ("cmod_mm", "load_min_n", "load_max_n")}


def read(case: Case, out: Path) -> Curve | None:
    """Curve of a case that is done."""
    folder = out / case.name
    if not (folder / "result.json").exists():
        return None
    with (folder / "curve.csv").open() as file:
        rows = list(csv.DictReader(file))
    column = lambda key: [float(row[key]) for row in rows if key in row]
    result = json.loads((folder / "result.json").read_text())
    return Curve(column("strain"), column("stress_mpa"), case.height, result, column("load_n"), column("mouth"))


def judge(chosen: list[Case], out: Path) -> None:
    """Write the figures of all cases and of all rows."""
    done = {case: curve for case in chosen if (curve := read(case, out))}
    with (out / "cases.csv").open("w", newline="") as file:
        table = csv.writer(file)
        names = "case modulus_gpa peak_mpa peak_strain left_0.3 left_0.4 left_0.5 end to_60_mm half_mm "
        names += "energy_to_60 energy_n_per_mm kinetic balance"
        table.writerow(names.split())
        table.writerows([case.name, *figures(curve)] for case, curve in done.items())
    with (out / "rows.csv").open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["source", "quantity", "bar", "mean", "scatter", "seeds", "verdict"])
        for row in ROWS:
            line = verdict(row, done)
            table.writerow(line)
            print("  ".join(line))


def figures(curve: Curve) -> list[str]:
    """Cells of a case in cases.csv."""
    result, left = curve.result, [curve.left_at(strain) for strain in (0.003, 0.004, 0.005)]
    values = [result["modulus_mpa"] / 1000, curve.peak, curve.strain[curve.top] * 1000, *left]
    values += [curve.stress[-1] / curve.peak, curve.beyond_to(0.6), curve.beyond_to(0.5), curve.energy(0.6), curve.energy(0.2)]
    values += [result["kinetic_over_internal_max"], result["energy_balance_error"]]
    return ["" if value is None else f"{value:.4g}" for value in values]


# A row's figure from the curves of one seed by group and label; none where a curve is missing or does not reach it.
Curves = dict[str, Curve]


@dataclass(frozen=True)
class Row:
    """A row of the page: whose figure it is, the quantity, and its bar."""

    source: str
    quantity: str
    low: float
    high: float
    of: Callable[[Curves], float | None]


def over(above: str, below: str) -> Callable[[Curves], float | None]:
    """Ratio of two peaks."""
    return lambda curves: curves[above].peak / curves[below].peak


def figure(name: str, key: str) -> Callable[[Curves], float | None]:
    """One figure of a case's result."""
    return lambda curves: curves[name].result.get(key)


def apart(*names: str, of: Callable[[Curve], float | None]) -> Callable[[Curves], float | None]:
    """Largest over smallest figure of several cases, less 1."""

    def spread(curves: Curves) -> float | None:
        values = [of(curves[name]) for name in names]
        return None if any(value is None for value in values) else max(values) / min(values) - 1

    return spread


def heights_apart(curves: Curves) -> float:
    """Largest distance between three heights' stresses over peak at equal displacements from 0.1 to 0.6 mm beyond it."""
    worst = 0.0
    for at in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6):
        found = [curve.left_at(curve.strain[curve.top] + at / curve.height) for curve in
                 (curves[f"height-{h}"] for h in (50, 100, 200))]  # fmt: skip
        if None not in found:
            worst = max(worst, max(found) - min(found))
    return worst


def beam_rows(source: str, name: str) -> list[Row]:
    """Peak, opening at it, and work of a published beam: within its envelope, or a share beyond it."""
    beam, case = envelope(BEAMS[name][1].published), f"beam-{name}"
    low, high = beam["load_min_n"], beam["load_max_n"]
    wider = 0.15 if name == "mixed-mode" else 0.0
    opening = beam["cmod_mm"][high.index(max(high))]
    work = [under(beam["cmod_mm"], side, 0.1) for side in (low, high)]
    rows = [
        Row(source, f"{name}: peak, N", (1 - wider) * max(low), (1 + wider) * max(high), lambda c: max(c[case].load)),
        Row(source, f"{name}: opening at the peak, mm", 0.75 * opening, 1.25 * opening, lambda c: c[case].mouth_at_peak),
        Row(source, f"{name}: work until 0.1 mm, N mm", 0.9 * work[0], 1.1 * work[1], lambda c: c[case].opened()),
    ]
    return rows if name != "no-notch" else [rows[0], rows[2]]


def published(name: str) -> tuple[list[float], list[float]]:
    """Strain and stress of a published curve, compression positive, in rising strain."""
    with (HERE / f"{name}.csv").open() as file:
        points = sorted((-float(strain), -float(stress)) for strain, stress in csv.reader(file))
    return [e for e, _ in points], [s for _, s in points]


def of_test(name: str, height_mm: float) -> Curve:
    """A published curve of a specimen of this height."""
    strain, stress = published(name)
    return Curve(strain, stress, height_mm, {}, [], [])


def about(share: float, *values: float) -> tuple[float, float]:
    """A bar: a share below the least value and above the largest."""
    return (1 - share) * min(values), (1 + share) * max(values)


NAMES = {0.0: "uniaxial", 1.0: "1_1", 0.52: "1_052"}
KUPFER = {ratio: of_test(f"kupfer_{name}", 200.0) for ratio, name in NAMES.items()}
KARSAN = of_test("karsan_jirsa_uniaxial", 82.0)
READ = "Kupfer et al. 1969", "Karsan and Jirsa 1969", "BAM 2024, KIT 2023"
REMEMBERED = "remembered"


def strain_at(name: str) -> Callable[[Curves], float]:
    """Strain at the peak of a case, per mille."""
    return lambda curves: 1000 * curves[name].strain_at_peak


def shape_ratios() -> list[float]:
    """Strength of cylinders over cubes of every mix."""
    with (HERE / "cube_over_cylinder.csv").open() as file:
        return [float(row["cylinder_over_cube"]) for row in csv.DictReader(line for line in file if not line.startswith("#"))]


def file_rows() -> list[Row]:
    """Rows whose bars are points of files beside this program."""
    kupfer, karsan, shapes = READ
    alone, free = KUPFER[0.0], "height-100"
    rows = [
        Row(kupfer, "modulus over strength, friction 0.005", *about(0.15, alone.secant() / alone.peak),
            lambda c: c[free].result["modulus_mpa"] / c[free].peak),
        Row(kupfer, "strain at the peak, friction 0.005, per mille", *about(0.15, 1000 * alone.strain_at_peak), strain_at(free)),
        Row(karsan, "the same", *about(0.15, 1000 * KARSAN.strain_at_peak), strain_at(free)),
    ]
    for ratio, case in ((1.0, "biaxial-1"), (0.52, "biaxial-0.52")):
        test = KUPFER[ratio]
        rows += [
            Row(kupfer, f"1 : {ratio:g} over one side, friction 0.005", *about(0.08, test.peak / alone.peak), over(case, free)),
            Row(kupfer, f"strain at the peak, 1 : {ratio:g}, per mille", *about(0.15, 1000 * test.strain_at_peak), strain_at(case)),
        ]
    both = f"{kupfer}; {karsan}"
    rows += [
        Row(both, "from the peak to 60 % of it, friction 0.005, mm", *about(0.25, alone.beyond_to(0.6), KARSAN.beyond_to(0.6)),
            lambda c: c[free].beyond_to(0.6)),
        Row(both, "energy beyond the peak to 60 %, friction 0.005, N/mm", *about(0.25, alone.energy(0.6), KARSAN.energy(0.6)),
            lambda c: c[free].energy(0.6)),
        *(Row(kupfer, f"left at {strain:.1%} of 200 x 200 x 50 mm", alone.left_at(strain) - 0.15, min(1, alone.left_at(strain) + 0.15),
              lambda c, strain=strain: c["kupfer-200"].left_at(strain)) for strain in (0.003, 0.004, 0.005)),
        Row(shapes, "cylinder, h = 2 d, over cube, steel", *about(0, *shape_ratios()), over("slenderness-0.6-h2", "cube-0.6")),
    ]
    return [*rows, *beam_rows("Gregoire et al. 2013 (chose G_f)", "no-notch"), *beam_rows("Gregoire et al. 2013 (chose G_f)", "half-notch"),
            *beam_rows("Garcia-Alvarez et al. 2012", "mixed-mode")]  # fmt: skip


# Rows of files, of standards and of the paper, and rows that are remembered and test nothing.
ROWS = [
    *file_rows(),
    Row("EN 1992-1-1, Table 3.1", "modulus at a peak of 35 MPa, GPa", 29, 35, lambda c: c["cube-0.1"].result["modulus_mpa"] / 1000),
    Row("EN 1992-1-1, Table 3.1 (calibrated)", "strain at the peak, friction 0.1, per mille", 1.8, 2.4, strain_at("cube-0.1")),
    Row("EN 1992-1-1, Table 3.1", "f_t / f_c", 0.06, 0.10, over("tension-72", "cube-0.1")),
    Row("ASTM C42", "cylinder, steel, h = 2 d over h = d", 0.81, 0.93, over("slenderness-0.6-h2", "slenderness-0.6-h1")),
    Row("Vonk 1992, as the method paper has it (calibrated)", "peak, friction 0.1, MPa", 33.8, 37.4, lambda c: c["cube-0.1"].peak),
    Row("Vonk 1992, as the method paper has it (calibrated)", "peak of 150 mm, friction 0.1, MPa", 33.8, 37.4, lambda c: c["vonk-150"].peak),
    Row("-", "peaks in elements of 2.4, 2.0, 1.6 mm apart", 0, 0.03,
        apart("elements-2.4", "elements-2.0", "elements-1.6", of=lambda curve: curve.peak)),
    Row("-", "displacements to half of 2.4, 2.0, 1.6 mm apart", 0, 0.2,
        apart("elements-2.4", "elements-2.0", "elements-1.6", of=lambda curve: curve.beyond_to(0.5))),
    Row(REMEMBERED, "from the peak to half, friction 0.1, mm", 0.25, 0.7, lambda c: c["cube-0.1"].beyond_to(0.5)),
    Row(REMEMBERED, "from the peak to half, friction 0.005, mm", 0.25, 0.7, lambda c: c["height-100"].beyond_to(0.5)),
    Row(REMEMBERED, "energy beyond the peak to 20 %, friction 0.1, N/mm", 10, 25, lambda c: c["cube-0.1"].energy(0.2)),
    Row(REMEMBERED, "energy beyond the peak to 20 %, friction 0.005, N/mm", 10, 25, lambda c: c["height-100"].energy(0.2)),
    Row(REMEMBERED, "prisms of h = d / 2, d, 2 d: shares of the peak apart", 0, 0.25, heights_apart),
    Row(REMEMBERED, "cube, friction 0.6 over 0.1", 1.15, 1.3, over("cube-0.6", "cube-0.1")),
    Row(REMEMBERED, "cylinder, teflon, h = d over h = 2 d", 0.9, 1.1, over("slenderness-0.005-h1", "slenderness-0.005-h2")),
    Row(REMEMBERED, "cylinder, h = d, steel over teflon", 1.15, 1.3, over("slenderness-0.6-h1", "slenderness-0.005-h1")),
    Row(REMEMBERED, "work of fracture, N/mm", 0.06, 0.14, lambda c: c["tension-72"].work()),
    Row(REMEMBERED, "stress of least volume over the peak", 0.75, 0.95, figure("cube-0.1", "least_volume_over_peak")),
    Row(REMEMBERED, "Poisson's ratio to 30 % of the peak", 0.15, 0.22, figure("cube-0.1", "poisson_ratio")),
    Row(REMEMBERED, "strength at a fraction of 0.2 over mortar's", 0.9, 1.1, over("fraction-0.2", "fraction-0.0")),
    Row(REMEMBERED, "strength at a fraction of 0.4 over mortar's", 0.9, 1.1, over("fraction-0.4", "fraction-0.0")),
]  # fmt: skip


def verdict(row: Row, done: dict[Case, Curve]) -> list[str]:
    """Cells of a row: mean and scatter over the seeds that have it."""
    found = []
    for seed in sorted({case.seed for case in done}):
        curves = {f"{case.group}-{case.label}": curve for case, curve in done.items() if case.seed == seed}
        try:
            value = row.of(curves)
        except KeyError:
            continue
        found += [] if value is None else [value]
    bar = f"{row.low:g} to {row.high:g}"
    if not found:
        return [row.source, row.quantity, bar, "-", "-", "0", "not run, or not reached"]
    mean = statistics.fmean(found)
    scatter = statistics.stdev(found) if len(found) > 1 else 0.0
    word = "inside" if row.low <= mean <= row.high else "outside"
    return [row.source, row.quantity, bar, f"{mean:.3g}", f"{scatter:.2g}", str(len(found)), word]


if __name__ == "__main__":
    sys.exit(main())
