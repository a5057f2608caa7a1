#!/usr/bin/env python3
"""Do the tests bite? Builds the code with every fault of tests/mutants.txt in it and switches on one after the other.

    python3 tests/mutants.py                 # all of them; enters benches/results/mutants.csv
    python3 tests/mutants.py check hull      # some rooms, and enters nothing

A fault is an expression in place of the right one where the variable MUTANT of the environment has its number. So all of
them take one build, of a copy in target/mutants. Each is run against the tests of its room alone, those that
end in seconds; a run that fails, breaks off or does not end in time has noticed it.
"""

import argparse
import csv
import json
import os
import re
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COPY = ROOT / "target" / "mutants" / "tree"
RESULTS = ROOT / "benches" / "results" / "mutants.csv"
# What must notice the faults of a room: of a crate's test binaries these tests; "lib" are the unit tests.
TESTS = {
    "gjk": [("meso-core", "lib", ["gjk::"]), ("meso-core", "collision", [])],
    "geometry": [
        ("meso-core", "lib", ["geometry::"]),
        ("meso-core", "core", ["hull::", "exact::", "shapes::", "offset::", "erosion::"]),
    ],
    "grading": [("meso-core", "core", ["grading::", "sieve::", "spec::"])],
    "specimens": [("meso-core", "lib", ["packing::specimen"]), ("meso-core", "core", ["specimens::"])],
    "check": [("meso-core", "lib", ["check::"]), ("meso-core", "core", ["check::", "lies::", "inclusions::"])],
    "laws": [("meso-solve", "lib", ["law::"]), ("meso-solve", "laws", ["cdp::"])],
}
# A run that takes so many times as long as without a fault, and so many seconds more, does not end.
PATIENCE = (5.0, 30.0)
SWITCH = """//! Which fault is switched on.

use std::sync::LazyLock;

static ON: LazyLock<u32> = LazyLock::new(|| std::env::var("MUTANT").ok().and_then(|text| text.parse().ok()).unwrap_or(0));

#[allow(missing_docs, unreachable_pub, clippy::disallowed_methods)]
#[inline]
pub fn is(number: u32) -> bool {
    *ON == number
}
"""


@dataclass
class Mutant:
    """A fault: number, room, tests, file, the right text with its changed part, and what stands there instead."""

    number: int
    room: str
    tests: str
    file: str
    right: str
    wrong: str
    reason: str = ""

    def part(self) -> tuple[str, str, str]:
        """Split the right text: before, changed, after."""
        found = re.fullmatch(r"(.*)\[\[(.*)\]\](.*)", self.right)
        return found.groups() if found else ("", self.right, "")


def main() -> int:
    """Build, run, print and enter."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rooms", nargs="*", help="all when absent")
    args = parser.parse_args()
    mutants = [m for m in read(ROOT / "tests" / "mutants.txt") if not args.rooms or m.room in args.rooms]
    plant(mutants)
    binaries = build(mutants)
    usual = {tests: right(tests, binaries) for tests in dict.fromkeys(m.tests for m in mutants)}
    rows = []
    for mutant in mutants:
        outcome = run(mutant, binaries, usual[mutant.tests])
        rows.append([mutant.number, mutant.room, mutant.file, mutant.right, mutant.wrong, outcome, mutant.reason])
        print(f"{mutant.number:3} {mutant.room:12} {outcome:10} {mutant.right} ==> {mutant.wrong}", flush=True)
    caught = sum(row[5] != "survives" for row in rows)
    print(f"{caught} of {len(rows)} caught: {100 * caught / len(rows):.0f} %")
    if not args.rooms:
        with RESULTS.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([["number", "room", "file", "right", "wrong", "outcome", "reason"], *rows])
    unexplained = [row[0] for row in rows if row[5] == "survives" and not row[6]]
    return 1 if unexplained else 0


def read(path: Path) -> list[Mutant]:
    """Read the list."""
    mutants: list[Mutant] = []
    room = tests = file = ""
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("== "):
            room, tests = line[3:].split(" : ")
        elif line.startswith("-- "):
            file = line[3:]
        elif line.startswith("# survives: "):
            mutants[-1].reason = line.removeprefix("# survives: ")
        elif " ==> " in line and not line.startswith("#"):
            mutants.append(Mutant(len(mutants) + 1, room, tests, file, *line.split(" ==> ")))
    return mutants


def plant(mutants: list[Mutant]) -> None:
    """Copy the sources and put all faults into the copy."""
    shutil.rmtree(COPY, ignore_errors=True)
    COPY.mkdir(parents=True)
    for name in ["crates", "tests", "benches", "examples", "docs"]:
        shutil.copytree(ROOT / name, COPY / name, ignore=shutil.ignore_patterns("__pycache__", "*.so", "results"))
    for name in ["Cargo.toml", "Cargo.lock", "README.md", "CHANGELOG.md", "LICENSE"]:
        shutil.copy2(ROOT / name, COPY / name)
    for crate in {m.file.split("/")[1] for m in mutants}:
        source = COPY / "crates" / crate / "src"
        (source / "mutant.rs").write_text(SWITCH, encoding="utf-8")
        library = (source / "lib.rs").read_text(encoding="utf-8")
        (source / "lib.rs").write_text(library + "\n#[doc(hidden)]\npub mod mutant;\n", encoding="utf-8")
    for place in dict.fromkeys((m.file, m.right) for m in mutants):
        here = [m for m in mutants if (m.file, m.right) == place]
        before, changed, after = here[0].part()
        text = (COPY / place[0]).read_text(encoding="utf-8")
        count = text.count(before + changed + after)
        if count != 1:
            sys.exit(f"{place[0]} has {count} times, not once: {place[1]}")
        cases = "".join(f"if crate::mutant::is({m.number}) {{ {m.wrong} }} else " for m in here)
        planted = f"{before}({cases}{{ {changed} }}){after}"
        (COPY / place[0]).write_text(text.replace(before + changed + after, planted), encoding="utf-8")


def build(mutants: list[Mutant]) -> dict[tuple[str, str], Path]:
    """Build the test binaries once; their paths by crate and target."""
    wanted = {(crate, target) for m in mutants for crate, target, _ in TESTS[m.tests]}
    found = {}
    for crate in sorted({crate for crate, _ in wanted}):
        targets = [word for c, t in sorted(wanted) if c == crate for word in (["--lib"] if t == "lib" else ["--test", t])]
        command = ["cargo", "test", "--no-run", "--message-format=json", "-p", crate, *targets]
        # The registry's crates are those of the usual build.
        env = {**os.environ, "CARGO_TARGET_DIR": str(ROOT / "target")}
        made = subprocess.run(command, cwd=COPY, env=env, stdout=subprocess.PIPE, text=True, check=True).stdout
        for message in map(json.loads, made.splitlines()):
            if message.get("executable") and message.get("profile", {}).get("test"):
                name = "lib" if "lib" in message["target"]["kind"] else message["target"]["name"]
                found[crate, name] = Path(message["executable"])
    return found


def right(tests: str, binaries: dict[tuple[str, str], Path]) -> float:
    """Run a room's tests without a fault; the seconds that they take."""
    start = time.monotonic()
    if not all(passes(which, binaries, 0, 3600.0) for which in TESTS[tests]):
        sys.exit(f"the tests of {tests} fail without any fault")
    return time.monotonic() - start


def run(mutant: Mutant, binaries: dict[tuple[str, str], Path], usual: float) -> str:
    """Run a fault's tests, up to the first that notices it."""
    limit = PATIENCE[0] * usual + PATIENCE[1]
    try:
        survives = all(passes(which, binaries, mutant.number, limit) for which in TESTS[mutant.tests])
    except subprocess.TimeoutExpired:
        return "hangs"
    return "survives" if survives else "caught"


def passes(which: tuple[str, str, list[str]], binaries: dict[tuple[str, str], Path], number: int, limit: float) -> bool:
    """Whether a binary's tests pass with this fault."""
    crate, target, filters = which
    env = {**os.environ, "MUTANT": str(number)}
    command = [str(binaries[crate, target]), *filters]
    return subprocess.run(command, cwd=COPY / "crates" / crate, env=env, capture_output=True, timeout=limit, check=False).returncode == 0


if __name__ == "__main__":
    sys.exit(main())
