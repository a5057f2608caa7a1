#!/usr/bin/env python3
"""What the fronts add to the work: CPU time of a study over its packings, of `mc.pack` over the command, and of the import.

    python3 benches/overheads.py                # with the wheel installed; enters benches/results/overheads.csv

Both sides of a ratio take turns, each in a process of its own, and the median of the ratios counts: CPU time says the same on
a busy machine. Wheel and command must be of one build profile; `--command` names another command. The last row ends a
study by `kill -9` at random moments and counts the cases that are lost beside the one in hand. `--quick` makes one turn
of two packings and three kills, and enters nothing.
"""

import argparse
import os
import random
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from origin import RESULTS, origin

TABLE = RESULTS / "overheads.csv"
HEADER = "what,cpu_s,of,of_cpu_s,ratio,bar,machine,date,commit"
SPEC = "specimen = { kind = 'cube', side_mm = 60 }\n"
ALONE = """
import mesocrete as mc
for seed in range(1, SEEDS + 1):
    for fraction in FRACTIONS:
        mc.pack({"specimen": {"kind": "cube", "side_mm": 60.0}}, seed=seed, fraction=fraction)
"""
STUDY = """
import mesocrete as mc
over = {"seed": range(1, SEEDS + 1), "fraction": FRACTIONS}
mc.study({"specimen": {"kind": "cube", "side_mm": 60.0}}, over, out="study")
"""
SAVED = """
import time
import mesocrete as mc
mc.pack
start = time.process_time()
mc.pack().write("model.json")
print(time.process_time() - start)
"""
FRACTIONS = [0.3, 0.4, 0.5]


def main() -> int:
    """Measure, print, and enter the rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--command", default=shutil.which("mesocrete"))
    parser.add_argument("--quick", action="store_true")
    args = parser.parse_args()
    seeds, turns, kills = (1, 1, 3) if args.quick else (20, 3, 20)
    python = [sys.executable, "-c"]
    fill = [f"SEEDS, FRACTIONS = {seeds}, {FRACTIONS}\n{text}" for text in (ALONE, STUDY)]
    study = f"[spec]\n{SPEC}[over]\nseed = {{ from = 1, to = {seeds} }}\nfraction = {FRACTIONS}\n"
    command = [args.command, "study", "study.toml", "-q"]
    rows = [
        compare("mc.study of 60 packings", [*python, fill[1]], "the packings", [*python, fill[0]], 1.1, turns, study),
        compare("mesocrete study of 60 packings", command, "mc.pack of them", [*python, fill[0]], 1.1, turns, study),
        compare("mc.pack and write", [*python, SAVED], "mesocrete pack", [args.command, "pack", "-q", "-o", "model.json"], 1.05, turns, study),
        imported(turns),
        killed(command, study, kills),
    ]
    lines = [HEADER, *(f"{row},{origin()}" for row in rows)]
    print("\n".join(lines))
    if not args.quick:
        TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return 0


def compare(what: str, command: list[str], of: str, other: list[str], bar: float, turns: int, study: str) -> str:
    """Let two commands take turns; medians of their CPU times and of the ratio."""
    pairs = [(cpu_seconds(command, study), cpu_seconds(other, study)) for _ in range(turns)]
    mine, theirs = (statistics.median(side) for side in zip(*pairs, strict=True))
    return f"{what},{mine:.2f},{of},{theirs:.2f},{statistics.median(a / b for a, b in pairs):.3f},{bar}"


def cpu_seconds(command: list[str], study: str) -> float:
    """CPU time of a command in an empty folder with a study; of a part of it, where it prints that."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "study.toml").write_text(study, encoding="utf-8")
        process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True)
        printed = process.stdout.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = status
    if status != 0:
        sys.exit(f"{command} failed")
    return float(printed) if printed else used.ru_utime + used.ru_stime


def imported(turns: int) -> str:
    """CPU time of `import mesocrete` and its first name beyond numpy, s; the bar is in seconds, too."""
    text = "import time, numpy; t = time.process_time(); import mesocrete; mesocrete.pack; print(time.process_time() - t)"
    least = min(cpu_seconds([sys.executable, "-c", text], "") for _ in range(5 * turns))
    return f"import mesocrete and its first name beyond numpy,{least:.3f},0.05 s,0.05,{least / 0.05:.3f},1.0"


def killed(command: list[str], study: str, kills: int) -> str:
    """The most cases without a record after any of some kills, beside the one in hand."""
    draw, lost, struck = random.Random(19), 0, 0
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "study.toml").write_text(study, encoding="utf-8")
        while struck < kills:
            process = subprocess.Popen([*command, "--jobs", "1"], cwd=folder)
            time.sleep(0.05 + draw.random())
            if process.poll() is not None:
                # All cases are done: from the first one on.
                shutil.rmtree(Path(folder) / "study")
                continue
            struck += 1
            process.kill()
            process.wait()
            cases = [case for case in (Path(folder) / "study").glob("seed-*") if case.is_dir()]
            lost = max(lost, sum(not (case / "case.json").exists() for case in cases))
    return f"cases lost by kill -9 at {struck} random moments,,at most the case in hand,,{lost},1"


if __name__ == "__main__":
    sys.exit(main())
