#!/usr/bin/env python3
"""Prints the README's table of times: packs the paper's specimen, one thread, and checks every packing.

    cargo build --release && python3 docs/measure.py [PATH/TO/mesocrete]
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

RUNS = {f"{fraction:.2f}": ["--fraction", str(fraction)] for fraction in (0.40, 0.50, 0.60, 0.65, 0.68, 0.70)}
RUNS["the paper's rule"] = ["--strategy", "take-and-place", "--attempts", "100"]


def main() -> None:
    """Print one row per run."""
    root = Path(__file__).resolve().parent.parent
    program = str(Path(sys.argv[1] if len(sys.argv) > 1 else root / "target/release/mesocrete").resolve())
    print("| fraction | aggregates | worst size class | CPU, s | memory, MB |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name, options in RUNS.items():
            print(row(program, name, options), flush=True)


def row(program: str, name: str, options: list[str]) -> str:
    """Pack once, check the result, and say what it took."""
    command = [program, "pack", "--threads", "1", "--quiet", "--force", "-o", "model.json", *options]
    process = subprocess.Popen([*command, "--summary-json", "summary.json"])
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(command)} failed")
    subprocess.run([program, "check", "model.json"], check=True, stdout=subprocess.DEVNULL)
    summary = json.loads(Path("summary.json").read_text(encoding="utf-8"))
    worst = max(abs(c["fraction"] / c["target_fraction"] - 1.0) for c in summary["classes"])
    seconds, megabytes = usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1000
    return f"| {name} | {summary['aggregates']:,} | {worst:.2%} off | {seconds:.1f} | {megabytes:.0f} |"


if __name__ == "__main__":
    main()
