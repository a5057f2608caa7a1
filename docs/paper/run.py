#!/usr/bin/env python3
"""Runs the compression tests of docs/measured/paper.md, one folder a case, and draws them.

    cargo build --release && python3 docs/paper/run.py OUT             everything at the paper's size: a night on two cores, 30 GB
    python3 docs/paper/run.py OUT --small                              50 mm cubes: less than two hours
    python3 docs/paper/run.py OUT --only friction --seeds 1            one group, one seed
    python3 docs/paper/run.py OUT --small --present --law meso         today's default materials, another law

A case whose result is there is skipped, and one that was killed goes on from its checkpoint, so the same command
finishes what was begun. Needs numpy, matplotlib and pyvista. The figures of every case go to
OUT/cases.csv, the pictures to OUT/*.png, the tables to the terminal.
"""

import argparse
import csv
import json
import shutil
import subprocess
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

try:
    import pictures
except ModuleNotFoundError as missing:
    sys.exit(f"{missing.name} is missing: pip install numpy matplotlib pyvista")

HERE = Path(__file__).resolve().parent
CHECKPOINT_S = "300"
# Exit code of a test that Ctrl-C or a termination stopped.
INTERRUPTED = 130
# What cases.csv keeps of a result.json.
FIGURES = [
    "elements", "steps", "modulus_mpa", "peak_mpa", "peak_strain", "stress_at_end_mpa", "softened",
    "kinetic_over_internal_max", "kinetic_over_internal_to_half_peak", "energy_balance_error",
    "added_mass_percent", "joined_pairs",
]  # fmt: skip


@dataclass
class Case:
    """One specimen, crushed once."""

    group: str
    label: str
    seed: int
    spec: dict
    flags: list[str] = field(default_factory=list)
    materials: str = ""
    base: str = ""

    @property
    def name(self) -> str:
        """Name of the folder."""
        return f"{self.group}-{self.label.replace(', h = ', '-').replace(' ', '')}-{self.seed}"


def main() -> None:
    """Run what is missing, then tabulate and draw all there is."""
    args = parse_args()
    if not args.draw and shutil.which(args.program) is None:
        sys.exit(f"{args.program} is missing: cargo build --release")
    args.out.mkdir(parents=True, exist_ok=True)
    every = [prepared(case, args) for case in cases(small=args.small)]
    chosen = [case for case in every if is_chosen(case, args)]
    folders = shared_folders(every, args.out)
    for number, case in enumerate(chosen, 1):
        if not args.draw:
            print(f"{number}/{len(chosen)} {case.name}", flush=True)
            run(args.program, case, folders[case.name])
    done = [(case, folders[case.name]) for case in chosen if read_result(folders[case.name])]
    tabulate(done, args.out / "cases.csv")
    pictures.draw(done, args.out)


def parse_args() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="folder of the results")
    parser.add_argument("--small", action="store_true", help="50 mm cubes")
    parser.add_argument("--only", action="append", default=[], metavar="GROUP", help="one group of cases; repeatable")
    parser.add_argument("--seeds", type=int, default=5, metavar="N", help="at most so many seeds (default 5)")
    parser.add_argument("--present", action="store_true", help="today's default materials instead of the page's former ones")
    parser.add_argument("--law", help="another law than the default")
    parser.add_argument("--draw", action="store_true", help="run nothing; tabulate and draw what is there")
    parser.add_argument("--program", default=str(HERE.parent.parent / "target/release/mesocrete"), help="the mesocrete to run")
    return parser.parse_args()


def is_chosen(case: Case, args: argparse.Namespace) -> bool:
    """Whether the command line asks for this case."""
    return case.seed <= args.seeds and (not args.only or case.group in args.only)


def prepared(case: Case, args: argparse.Namespace) -> Case:
    """The case with the materials and the law of the command line, unless it has a law of its own."""
    # The page's former defaults are of cdp.
    chosen = args.law or ("" if args.present else "cdp")
    law = ["--law", chosen] if chosen and "--law" not in case.flags else []
    return replace(case, base="" if args.present else FORMER, flags=[*case.flags, *law])


def cases(*, small: bool) -> list[Case]:
    """Name every case, seed by seed; groups that need the large specimen first."""
    whole, side = (50.0, 50.0) if small else (150.0, 100.0)
    # Elements of 2 mm, with their shorter steps, would take five times as long: (3 / 2)^4.
    coarse = [] if small else ["--element-size-mm", "3"]
    found = []
    for seed in range(1, 4):
        # Sections at the points of the curve are drawn of one seed.
        frames = "20" if seed == 1 else "1"
        for friction in ("0.1", "0.6"):
            found.append(Case("friction", friction, seed, cube(whole, seed), ["--friction", friction, "--frames", frames]))
    for seed in range(1, 6):
        found += influences(side, seed, coarse)
        # The paper's four sizes; with 1.2 mm the cubes of 100 mm would take the night for themselves.
        for size in ("2.4", "2.0", "1.6", "1.2"):
            elements = ["--element-size-mm", size]
            found.append(Case("meshes", size, seed, cube(50.0, seed), elements))
            found.append(Case("unsmoothed", size, seed, cube(50.0, seed), [*elements, "--smoothing", "none"]))
            if not small and size != "1.2":
                found.append(Case("meshes-100", size, seed, cube(100.0, seed), elements))
        found += slenderness(side, seed, coarse)
    for seed in range(1, 4):
        found += other_law(seed)
    return found


def shared_folders(all_cases: list[Case], out: Path) -> dict[str, Path]:
    """One folder for all cases that are the same test, named after the first of them."""
    first: dict[str, Path] = {}
    return {case.name: first.setdefault(words_of(case), out / case.name) for case in all_cases}


def words_of(case: Case) -> str:
    """What decides the result of a case: its spec, flags and materials, but not how many frames are kept."""
    flags = with_defaults(case.flags)
    at = flags.index("--frames")
    return json.dumps([case.spec, sorted(flags[:at] + flags[at + 2 :]), materials_of(case)], sort_keys=True)


def influences(side: float, seed: int, coarse: list[str]) -> list[Case]:
    """The paper's Sec. 4: fraction, strength of the ITZ over the mortar's, thickness of a solid ITZ."""
    found = []
    for fraction in (0.2, 0.3, 0.4):
        found.append(Case("fraction", f"{fraction}", seed, cube(side, seed, fraction), coarse))
    for ratio in ("0.5", "0.7", "0.9"):
        # 0.7 is the default.
        text = "" if ratio == "0.7" else f"itz_strength_ratio = {ratio}"
        found.append(Case("itz", ratio, seed, cube(side, seed), coarse, text))
    for thickness in (0.1, 0.3, 0.5):
        # Elements of 3 mm would give a layer of 0.1 mm 2.7 times its volume, and those of 2 mm still 1.2 times.
        layer = ["--itz", "solid", "--accept-phase-error"]
        found.append(Case("thickness", f"{thickness}", seed, cube(side, seed, itz=thickness), layer))
    return found


def slenderness(side: float, seed: int, coarse: list[str]) -> list[Case]:
    """Cylinders once and twice as high as wide: plates of greased teflon, of dry steel, and with a friction between."""
    found = []
    for friction in ("0.005", "0.1", "0.6"):
        for height in (1, 2):
            flags = ["--friction", friction, *coarse]
            found.append(Case("slenderness", f"{friction}, h = {height} d", seed, cylinder(side, height, seed), flags))
    return found


def other_law(seed: int) -> list[Case]:
    """CDPM2 in place of the decks' damaged plasticity: cubes of 50 mm, and cylinders between rough plates."""
    law = ["--law", "cdpm2", "--friction"]
    cubes = [Case("cdpm2", friction, seed, cube(50.0, seed), [*law, friction]) for friction in ("0.1", "0.6")]
    shapes = [(f"0.6, h = {height} d", cylinder(50.0, height, seed)) for height in (1, 2)]
    return cubes + [Case("cdpm2", label, seed, spec, [*law, "0.6"]) for label, spec in shapes]


def cube(side: float, seed: int, fraction: float = 0.4, itz: float | None = None) -> dict:
    """The paper's concrete: Fuller 5 to 20 mm (16 mm below 100 mm), with gaps of 1 mm, which elements of 2 mm show."""
    largest = 20.0 if side >= 100.0 else 16.0
    spec = {
        "seed": seed,
        "fraction": fraction,
        "specimen": {"kind": "cube", "side_mm": side},
        "grading": {"d_min_mm": 5.0, "d_max_mm": largest, "classes_mm": [5.0, 10.0, 15.0, largest]},
        "placement": {"min_gap_mm": 1.0},
    }
    if itz is not None:
        spec["itz"] = {"thickness_mm": [itz, itz]}
    return spec


def cylinder(side: float, height: int, seed: int) -> dict:
    """The same concrete in a cylinder, so many times as high as wide."""
    specimen = {"kind": "cylinder", "diameter_mm": side, "height_mm": height * side}
    return {**cube(side, seed), "specimen": specimen}


def run(program: str, case: Case, folder: Path) -> None:
    """Crush it, unless that was done with the same words before."""
    folder.mkdir(exist_ok=True)
    words = words_of(case)
    asked = folder / "asked.json"
    same = asked.exists() and asked.read_text(encoding="utf-8") == words
    if same and read_result(folder):
        return
    (folder / "SPEC.toml").write_text(to_toml(case.spec), encoding="utf-8")
    (folder / "materials.toml").write_text(materials_of(case), encoding="utf-8")
    asked.write_text(words, encoding="utf-8")
    resume = ["--resume"] if same and (folder / "checkpoint.bin").exists() else []
    command = [program, "solve", str(folder / "SPEC.toml"), "-o", str(folder), "--force", "--quiet"]
    command += ["--materials", str(folder / "materials.toml"), "--checkpoint", CHECKPOINT_S, *resume]
    command += with_defaults(case.flags)
    with (folder / "messages.txt").open("w", encoding="utf-8") as messages:
        code = subprocess.run(command, stderr=messages, check=False).returncode
    if code == INTERRUPTED:
        # Its checkpoint stays, and so does what it was asked.
        sys.exit(code)
    if code != 0:
        asked.unlink()
        print(f"  failed: {(folder / 'messages.txt').read_text(encoding='utf-8').strip()}", file=sys.stderr)


# The defaults of the time when the page was measured, in TOML.
FORMER = """aggregate.youngs_modulus_mpa = 70000
mortar.youngs_modulus_mpa = 26000
itz.youngs_modulus_mpa = 20000
mortar_strength.compressive_mpa = 40
mortar_strength.peak_strain = 0.0022
mortar_strength.tensile_mpa = 3.0
mortar_strength.fracture_energy_n_per_mm = 0.06
mortar_strength.crushing_energy_n_per_mm = 0.5
plasticity.dilation_angle_deg = 30
plasticity.meridian_ratio = 0.75
"""


def materials_of(case: Case) -> str:
    """Materials of all cases, with the values that the case changes."""
    return f"[materials]\n{case.base}{case.materials}\n"


def with_defaults(flags: list[str]) -> list[str]:
    """Elements of 2 mm, a friction of 0.1 and one frame, unless the case says otherwise."""
    usual = {"--element-size-mm": "2", "--friction": "0.1", "--frames": "1"}
    return [*flags, *(word for flag, value in usual.items() if flag not in flags for word in (flag, value))]


def to_toml(table: dict) -> str:
    """Write a spec of two levels as TOML."""
    top = "".join(f"{key} = {json.dumps(value)}\n" for key, value in table.items() if not isinstance(value, dict))
    inner = {key: value for key, value in table.items() if isinstance(value, dict)}
    return top + "".join(
        f"[{key}]\n" + "".join(f"{name} = {json.dumps(value)}\n" for name, value in values.items())
        for key, values in inner.items()
    )


def tabulate(done: list[tuple[Case, Path]], path: Path) -> None:
    """Write the figures of every case, and print mean and scatter of every label."""
    rows = [(case, read_result(folder)) for case, folder in done]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["group", "label", "seed", *FIGURES, "solve_s"])
        for case, result in rows:
            writer.writerow([case.group, case.label, case.seed, *map(result.get, FIGURES), result["seconds"]["solve"]])
    print("| group | label | seeds | modulus, MPa | peak, MPa | peak strain | end over peak |\n|---|---|---|---|---|---|---|")
    for group, label in dict.fromkeys((case.group, case.label) for case, _ in rows):
        print(row(group, label, [r for case, r in rows if (case.group, case.label) == (group, label)]))


def row(group: str, label: str, results: list[dict]) -> str:
    """Mean and standard deviation over the seeds of a label, as a row of a table."""
    import numpy as np

    left = [result["stress_at_end_mpa"] / result["peak_mpa"] for result in results]
    columns = [np.array([result[key] for result in results]) for key in ("modulus_mpa", "peak_mpa", "peak_strain")]
    digits = [0, 1, 5, 2]
    cells = [f"{x.mean():.{n}f} ± {x.std():.{n}f}" for x, n in zip([*columns, np.array(left)], digits, strict=True)]
    return f"| {group} | {label} | {len(results)} | {' | '.join(cells)} |"


def read_result(folder: Path) -> dict | None:
    """Read the figures of a case that came to its end."""
    path = folder / "result.json"
    result = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return result if result.get("ended") == "completed" else None


if __name__ == "__main__":
    main()
