#!/usr/bin/env python3
"""Do the tests bite? Builds the code with every fault of tools/mutants.txt in it and switches on one after the other.

    python3 tools/mutants.py                 # all of them
    python3 tools/mutants.py check hull      # some rooms
    python3 tools/mutants.py 4 22            # some faults

A fault is an expression in place of the right one where the variable MUTANT of the environment has its number. So all of
them take one build, of a copy in target/mutants. Each is run against the tests of its room alone, those that
end in seconds; a run that fails, breaks off or does not end in time has noticed it. Outcomes are entered in
benches/results/mutants.csv, beside those of earlier runs.
"""

import argparse
import csv
import json
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "benches"))
from origin import origin  # noqa: E402

COPY = ROOT / "target" / "mutants" / "tree"
RESULTS = ROOT / "benches" / "results" / "mutants.csv"
OUTCOME = ["outcome", "machine", "date", "commit"]
# What must notice the faults of a room: of a crate's test binaries these tests; "lib" are the unit tests.
TESTS = {
    "gjk": [("meso-collision", "lib", ["gjk::"]), ("meso-collision", "collision", [])],
    "lockstep": [("meso-collision", "lib", ["gjk::many"]), ("meso-collision", "collision", ["batches::", "packed::"])],
    "geometry": [
        ("meso-collision", "lib", ["geometry::"]),
        ("meso-collision", "collision", ["hull::", "offset::"]),
        ("meso-core", "core", ["shapes::"]),
    ],
    "grading": [("meso-core", "core", ["grading::", "spec::"]), ("meso-collision", "collision", ["sieve::"])],
    "specimens": [("meso-concrete", "lib", ["specimen"]), ("meso-core", "core", ["specimens::"])],
    "check": [("meso-pack", "lib", ["check::"]), ("meso-core", "core", ["check::", "lies::", "inclusions::"])],
    "solver": [("meso-solve", "lib", []), ("meso-solve", "solve", ["elastic::", "softening::"])],
    "laws": [("meso-element", "lib", ["law::"]), ("meso-element", "laws", ["cdp::", "meso::"])],
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

    def key(self) -> tuple[str, str, str]:
        """Name the fault by what it is, since numbers change."""
        return self.file, self.right, self.wrong

    def part(self) -> tuple[str, str, str]:
        """Split the right text: before, changed, after."""
        found = re.fullmatch(r"(.*)\[\[(.*)\]\](.*)", self.right)
        return found.groups() if found else ("", self.right, "")


def main() -> int:
    """Build, run, print and enter."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rooms", nargs="*", help="or numbers of faults; all when absent")
    args = parser.parse_args()
    mutants = read(ROOT / "tools" / "mutants.txt")
    plant(faulty(mutants))
    chosen = [m for m in mutants if not args.rooms or m.room in args.rooms or str(m.number) in args.rooms]
    binaries = build(chosen)
    usual = {tests: right(tests, binaries) for tests in dict.fromkeys(m.tests for m in chosen)}
    outcomes = entered()
    for mutant in chosen:
        outcome = run(mutant, binaries, usual[mutant.tests])
        outcomes[mutant.key()] = [outcome, *origin().split(",")]
        print(f"{mutant.number:3} {mutant.room:12} {outcome:10} {mutant.right} ==> {mutant.wrong}", flush=True)
        enter(mutants, outcomes)
    told = [outcomes[m.key()][0] for m in mutants if m.key() in outcomes]
    caught = sum(outcome != "survives" for outcome in told)
    print(f"{caught} of {len(told)} caught: {100 * caught / len(told):.0f} %; {len(mutants) - len(told)} were never run")
    unexplained = [m.number for m in chosen if outcomes[m.key()][0] == "survives" and not m.reason]
    return 1 if unexplained else 0


def entered() -> dict[tuple[str, str, str], list[str]]:
    """Read the outcomes of earlier runs, each with its machine, date and commit."""
    if not RESULTS.exists():
        return {}
    with RESULTS.open(encoding="utf-8", newline="") as file:
        return {(row["file"], row["right"], row["wrong"]): [row[name] for name in OUTCOME] for row in csv.DictReader(file)}


def enter(mutants: list[Mutant], outcomes: dict[tuple[str, str, str], list[str]]) -> None:
    """Write the outcomes of the mutants that were run."""
    rows = [[m.number, m.room, *m.key(), m.reason, *outcomes[m.key()]] for m in mutants if m.key() in outcomes]
    with RESULTS.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([["number", "room", "file", "right", "wrong", "reason", *OUTCOME], *rows])


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


def faulty(mutants: list[Mutant]) -> dict[Path, bytes]:
    """Read the sources and put all faults into them; exits if one does not have exactly one place."""
    texts = {path.relative_to(ROOT): path.read_bytes() for path in sources()}
    for crate in {m.file.split("/")[1] for m in mutants}:
        source = Path("crates") / crate / "src"
        texts[source / "mutant.rs"] = SWITCH.encode()
        texts[source / "lib.rs"] += b"\n#[doc(hidden)]\npub mod mutant;\n"
    for file, right in dict.fromkeys((m.file, m.right) for m in mutants):
        here = [m for m in mutants if (m.file, m.right) == (file, right)]
        before, changed, after = here[0].part()
        text = texts[Path(file)].decode()
        if (count := text.count(before + changed + after)) != 1:
            sys.exit(f"{file} has {count} times, not once: {right}")
        cases = "".join(f"if crate::mutant::is({m.number}) {{ {m.wrong} }} else " for m in here)
        planted = f"{before}({cases}{{ {changed} }}){after}"
        texts[Path(file)] = text.replace(before + changed + after, planted).encode()
    return texts


def plant(texts: dict[Path, bytes]) -> None:
    """Write the copy; what is there already keeps its age, and is not compiled again."""
    for old in [path for path in COPY.rglob("*") if path.is_file() and path.relative_to(COPY) not in texts]:
        old.unlink()
    for name, text in texts.items():
        path = COPY / name
        if not path.exists() or path.read_bytes() != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text)


def sources() -> list[Path]:
    """Name the files that the tests' crates are built from."""
    folders = [ROOT / name for name in ["crates", "tests", "benches", "examples", "docs"]]
    files = [path for folder in folders for path in folder.rglob("*") if path.is_file()]
    return [path for path in files if path.suffix not in {".so", ".pyc"}] + [ROOT / name for name in ["Cargo.toml", "Cargo.lock", "README.md", "CHANGELOG.md", "LICENSE"]]


def build(mutants: list[Mutant]) -> dict[tuple[str, str], Path]:
    """Build the test binaries once; their paths by crate and target."""
    wanted = {(crate, target) for m in mutants for crate, target, _ in TESTS[m.tests]}
    found = {}
    for crate in sorted({crate for crate, _ in wanted}):
        targets = [word for c, t in sorted(wanted) if c == crate for word in (["--lib"] if t == "lib" else ["--test", t])]
        command = ["cargo", "test", "--no-run", "--message-format=json", "-p", crate, *targets]
        # Not the usual folder: cargo would take the copy's crates for the tree's own, and test those from then on.
        env = {**os.environ, "CARGO_TARGET_DIR": str(COPY.parent / "build")}
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
    """Whether a binary's tests pass with this fault; the first that fails ends it, as the others tell nothing more."""
    crate, target, filters = which
    env = {**os.environ, "MUTANT": str(number), "RUST_BACKTRACE": "0"}
    command = [str(binaries[crate, target]), *filters]
    run = subprocess.Popen(command, cwd=COPY / "crates" / crate, env=env, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    late = threading.Event()
    clock = threading.Timer(limit, lambda: (late.set(), run.kill()))
    clock.start()
    with run:
        if any(line.endswith("... FAILED\n") for line in run.stdout):
            run.kill()
    clock.cancel()
    if late.is_set():
        raise subprocess.TimeoutExpired(command, limit)
    return run.returncode == 0


if __name__ == "__main__":
    sys.exit(main())
