#!/usr/bin/env python3
"""Strength of concrete over the rate of strain: what the law adds, and what the inertia of the specimen does.

    python3 benches/rates.py --program target/release/mesocrete
    python3 benches/rates.py --quick        one packing and one rate

Cubes of 36 mm with 40 % of grains of 5 to 16 mm (elements of 3 mm, three packings) are pulled and pressed between two
plates in real time, with and without the `rate_effect` of the law. The strength at rest is that of the quasi-static test
of the same mesh. The fib curve is that of fib Model Code 2010, 5.1.11, both branches.
"""

import argparse
import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from origin import origin  # noqa: E402

SIDE_MM = 36.0
ELEMENT_MM = 3.0
TENSION, COMPRESSION = (1.0, 10.0, 30.0), (3.0, 10.0, 30.0, 100.0)
# Strains at which the tests end, beyond the peak.
ENDS = {"tension": 6e-4, "compression": 6e-3}
FIELDS = ["load", "rate_per_s", "seed", "law", "peak_mpa", "over_rest", "fib", "kinetic_over_internal"]


def fib(load: str, rate: float) -> float:
    """Strength over that at rest, both branches."""
    exponent, rest, turn, steep = (0.018, 1e-6, 10.0, 0.0062) if load == "tension" else (0.014, 30e-6, 30.0, 0.012)
    return (rate / rest) ** exponent if rate <= turn else steep * (rate / rest) ** (1 / 3)


def spec(seed: int) -> str:
    """The concrete."""
    return (
        f"seed = {seed}\nfraction = 0.4\n[specimen]\nkind = \"cube\"\nside_mm = {SIDE_MM}\n"
        "[grading]\nd_min_mm = 5.0\nd_max_mm = 16.0\n[placement]\nmin_gap_mm = 1.0\n"
    )


def test(load: str, rate: float, law: str) -> str:
    """A TEST.toml: two plates move with half of the speed each, after a rise of a twentieth of the time."""
    if not rate:
        friction = "" if load == "tension" else "friction = 0.1\n"
        return f'kind = "{load}"\n{friction}'
    speed = 0.5e-3 * rate * SIDE_MM * (1 if load == "compression" else -1)
    duration = ENDS[load] / rate
    rows = [[0, 0], [duration / 20, speed], [10 * duration, speed]]
    lines = [f"duration_s = {duration:.6e}", 'control = "steady"', f"rate_effect = {str(law == 'fib').lower()}"]
    for name, side in (("bottom", "z-min"), ("top", "z-max")):
        rule = 'rule = "glued"' if load == "tension" else 'rule = "plate"\nfriction = 0.1'
        drive = f'drive = {{ kind = "speed", speed_m_per_s = {json.dumps(rows)} }}'
        lines.append(f'[[supports]]\nname = "{name}"\non = "{side}"\n{rule}\n{drive}')
    return "\n".join(lines) + "\n"


def solve(program: str, folder: Path, seed: int, text: str) -> dict:
    """Result of one test."""
    (folder / "spec.toml").write_text(spec(seed))
    (folder / "test.toml").write_text(text)
    command = [program, "solve", "spec.toml", "-o", "out", "--test", "test.toml", "--force", "--quiet", "--frames", "0"]
    command += ["--element-size-mm", str(ELEMENT_MM), "--accept-phase-error"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    found = folder / "out" / "result.json"
    if not found.exists():
        sys.exit(done.stderr)
    return json.loads(found.read_text())


def main() -> None:
    """Run all tests and write benches/results/rates.csv."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(HERE.parent / "target/release/mesocrete"))
    parser.add_argument("--out", type=Path, default=HERE / "results" / "rates.csv")
    parser.add_argument("--quick", action="store_true", help="one packing and one rate")
    args = parser.parse_args()
    rows = []
    for seed in (1,) if args.quick else (1, 2, 3):
        for load, rates in (("tension", TENSION), ("compression", COMPRESSION)):
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                rest = solve(args.program, folder, seed, test(load, 0.0, ""))["peak_mpa"]
                for rate in rates[1:2] if args.quick else rates:
                    for law in ("at rest", "fib"):
                        found = solve(args.program, folder, seed, test(load, rate, law))
                        share = found["energies"]["kinetic"] / found["energies"]["internal"]
                        over = found["peak_mpa"] / rest
                        rows.append([load, rate, seed, law, f"{found['peak_mpa']:.3f}", f"{over:.3f}"])
                        rows[-1] += [f"{fib(load, rate):.3f}", f"{share:.2e}"]
                        print(*rows[-1], flush=True)
    if args.quick:
        return
    with args.out.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([*FIELDS, "machine", "date", "commit"])
        writer.writerows([*row, *origin().split(",")] for row in rows)


if __name__ == "__main__":
    main()
