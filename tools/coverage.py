#!/usr/bin/env python3
"""How many lines of the core do its own Rust tests run? Builds them with counters, runs them, and prints a table by folder.

    python3 tools/coverage.py                             # the libraries below meso-solve
    python3 tools/coverage.py --solver                    # and meso-solve
    python3 tools/coverage.py --missing meso-pack/check   # and the lines of a folder that no test runs
    python3 tools/coverage.py --again --enter             # the last run's counts, entered in benches/results/coverage.csv

Counted are the lines of crates/*/src that have code, without unit tests. What other crates call is not counted: the
command's and Python's tests reach more lines of the core than these. The build stands apart, in target/coverage.
A Unix shell, and rustup's component llvm-tools, are needed.
"""

import argparse
import csv
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from stage import ROOT, run, told_again  # noqa: E402

sys.path.insert(0, str(ROOT / "benches"))
from origin import origin  # noqa: E402

OUTPUT = ROOT / "target" / "coverage"
RAW, COUNTS = OUTPUT / "raw", OUTPUT / "counts.lcov"
RESULTS = ROOT / "benches" / "results" / "coverage.csv"
COLUMNS = ["what", "lines", "covered", "percent", "machine", "date", "commit"]

# Whose lines are counted, and the targets of their tests.
CORE = {"meso-collision": ["collision"], "meso-concrete": [], "meso-place": [], "meso-spec": [], "meso-pack": [], "meso-mesh": [], "meso-trial": [], "meso-view": [], "meso-write": [], "meso-core": ["core"]}
SOLVER = {"meso-element": ["laws"], "meso-solve": ["solve"]}

# Of a file, how often each line with code was run.
Counts = dict[str, dict[int, int]]
# A folder of a crate, its lines with code, and those that were run.
Row = tuple[str, int, int]


def main() -> int:
    """Build, run, count, print."""
    args = parse_args()
    crates = {**CORE, **(SOLVER if args.solver else {})}
    code = 0
    if not args.again:
        tools = find_tools()
        code = test(crates)
        export(tools, binaries(crates))
    elif not COUNTS.exists():
        sys.exit(f"{COUNTS.relative_to(ROOT)} is not there; run tools/coverage.py without --again first")
    counts = own_lines(read_lcov(COUNTS.read_text(encoding="utf-8")), ROOT)
    rows = table(counts)
    print(shown(rows))
    for folder in args.missing:
        print("", *missing(counts, folder), sep="\n")
    if args.enter:
        enter(rows, RESULTS)
    if code:
        print("some tests failed, so lines may be missing")
    return code


def parse_args() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--solver", action="store_true", help="test and count meso-solve, too")
    parser.add_argument("--missing", action="append", default=[], metavar="FOLDER", help="print the lines of this folder that no test runs")
    parser.add_argument("--again", action="store_true", help="build and run nothing; print the counts of the last run")
    parser.add_argument("--enter", action="store_true", help="write benches/results/coverage.csv")
    return parser.parse_args()


def find_tools() -> Path:
    """Find the folder of llvm-profdata and llvm-cov that know this compiler's format; others of the system may not."""
    host = re.search(r"^host: (.*)$", output(["rustc", "-vV"]), re.MULTILINE)[1]
    folder = Path(output(["rustc", "--print", "sysroot"]).strip()) / "lib" / "rustlib" / host / "bin"
    absent = [name for name in ("llvm-profdata", "llvm-cov") if shutil.which(name, path=str(folder)) is None]
    if absent:
        sys.exit(f"{' and '.join(absent)} not in {folder}; install them with: rustup component add llvm-tools")
    return folder


def test(crates: dict[str, list[str]]) -> int:
    """Build the tests with counters and run them; 1 where one failed."""
    os.environ.update(environment())
    shutil.rmtree(RAW, ignore_errors=True)
    if run("cargo build with counters", [*cargo_test(crates), "--no-run", "--quiet"]).code:
        sys.exit("nothing is counted: the build failed")
    tested = run("cargo test with counters", [*cargo_test(crates), "--no-fail-fast"])
    print(*told_again([tested]), sep="\n")
    return 1 if tested.code else 0


def environment() -> dict[str, str]:
    """Build this workspace's crates alone with counters: those of other crates would cost time and be thrown away."""
    OUTPUT.mkdir(parents=True, exist_ok=True)
    wrapper = OUTPUT / "rustc"
    # Loops count in a register and add it up at their end.
    wrapper.write_text('#!/bin/sh\nexec "$@" -Cinstrument-coverage -Cllvm-args=-do-counter-promotion\n', encoding="utf-8")
    wrapper.chmod(0o755)
    return {
        "RUSTC_WORKSPACE_WRAPPER": str(wrapper),
        "CARGO_TARGET_DIR": str(OUTPUT),
        "CARGO_INCREMENTAL": "0",
        "LLVM_PROFILE_FILE": str(RAW / "%m-%p.profraw"),
    }


def cargo_test(crates: dict[str, list[str]]) -> list[str]:
    """Begin the command of the crates' unit tests and test targets."""
    packages = [word for crate in crates for word in ("-p", crate)]
    targets = [word for names in crates.values() for name in names for word in ("--test", name)]
    return ["cargo", "test", *packages, "--lib", *targets]


def binaries(crates: dict[str, list[str]]) -> list[str]:
    """Name the test programs that were run."""
    built = output([*cargo_test(crates), "--no-run", "--quiet", "--message-format=json"])
    messages = [json.loads(line) for line in built.splitlines()]
    return [m["executable"] for m in messages if m.get("executable") and m["profile"]["test"]]


def export(tools: Path, programs: list[str]) -> None:
    """Merge what the programs counted and write it line by line."""
    merged = OUTPUT / "merged.profdata"
    raw = [str(path) for path in sorted(RAW.glob("*.profraw"))]
    output([str(tools / "llvm-profdata"), "merge", "--sparse", "--output", str(merged), *raw])
    # A program at a time: of a function that one program leaves out and another runs, llvm-cov drops the second, or not,
    # by the order of the programs. It warns of those, and `read_lcov` joins what it gives.
    profile = ["--format=lcov", "--instr-profile", str(merged)]
    COUNTS.write_text("".join(output([str(tools / "llvm-cov"), "export", *profile, program]) for program in programs), encoding="utf-8")


def output(command: list[str]) -> str:
    """Run a command from the project's root; what it prints."""
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def read_lcov(text: str) -> Counts:
    """Read an export of llvm-cov: `SF:` names a file, `DA:` a line of it and how often it was run."""
    counts: Counts = {}
    for line in text.splitlines():
        tag, _, rest = line.partition(":")
        if tag == "SF":
            lines = counts.setdefault(rest, {})
        elif tag == "DA":
            number, times = map(int, rest.split(",")[:2])
            lines[number] = max(times, lines.get(number, 0))
    return counts


def own_lines(counts: Counts, root: Path) -> Counts:
    """Keep the lines of crates/*/src that are no tests; files by their names below `root`."""
    found: Counts = {}
    for name in sorted(counts):
        path = Path(name)
        if not (path.is_relative_to(root / "crates") and path.relative_to(root).parts[2] == "src"):
            continue
        tests = test_lines(path.read_text(encoding="utf-8")) if not is_test_file(path) else counts[name]
        found[path.relative_to(root).as_posix()] = {n: times for n, times in counts[name].items() if n not in tests}
    return {name: lines for name, lines in found.items() if lines}


def is_test_file(path: Path) -> bool:
    """Whether the module of a file is declared for tests alone."""
    inside = [path.parent / name for name in ("mod.rs", "lib.rs")] + [path.parent.with_suffix(".rs")]
    declared = re.compile(rf"#\[cfg\(test\)\]\s+mod {path.stem};")
    return any(parent.exists() and declared.search(parent.read_text(encoding="utf-8")) for parent in inside)


def test_lines(source: str) -> set[int]:
    """Number the lines of items that only tests have; rustfmt ends an item at the depth where it began."""
    found: set[int] = set()
    end = None
    for number, line in enumerate(source.splitlines(), 1):
        if end is None and line.strip() == "#[cfg(test)]":
            depth = line[: line.index("#")]
            end = re.compile(rf"{depth}(?:\S.*[;}}]|\}};?)$")
            found.add(number)
        elif end is not None:
            found.add(number)
            end = None if end.match(line) else end
    return found


def table(counts: Counts) -> list[Row]:
    """Sum up the lines of each crate, and then of its folders; `src` are the files outside of them."""
    sums: dict[str, list[int]] = {}
    for name, lines in counts.items():
        crate, folder = place(name, counts)
        for what in (crate, f"{crate}/{folder}"):
            total = sums.setdefault(what, [0, 0])
            total[0] += len(lines)
            total[1] += sum(times > 0 for times in lines.values())
    return [(what, lines, covered) for what, (lines, covered) in sorted(sums.items())]


def place(name: str, names: Iterable[str]) -> tuple[str, str]:
    """Name a file's crate and folder; `check.rs` belongs to `check/`."""
    _, crate, _, first, *below = name.split("/")
    folder = first.removesuffix(".rs")
    has_folder = below or any(other.startswith(f"crates/{crate}/src/{folder}/") for other in names)
    return crate, folder if has_folder else "src"


def percent(row: Row) -> str:
    """How many of a hundred lines were run."""
    return f"{100 * row[2] / row[1]:.1f}"


def shown(rows: list[Row]) -> str:
    """Lay the rows out for a terminal."""
    width = max(len(row[0]) for row in rows)
    lines = [f"{'what':{width}} {'lines':>7} {'covered':>7} {'%':>6}"]
    return "\n".join([*lines, *(f"{row[0]:{width}} {row[1]:7} {row[2]:7} {percent(row):>6}" for row in rows)])


def missing(counts: Counts, folder: str) -> list[str]:
    """List the lines of a folder that no test runs, file by file; runs of lines as `first-last`."""
    found = []
    for name, lines in counts.items():
        without = [number for number in sorted(lines) if lines[number] == 0]
        if "/".join(place(name, counts)) == folder and without:
            found.append(f"{name}: {len(without)} of {len(lines)}: {', '.join(spans(without, sorted(lines)))}")
    return found or [f"{folder}: no line is missing"]


def spans(numbers: list[int], all_numbers: list[int]) -> list[str]:
    """Join lines between which no other line with code stands."""
    following = dict(zip(all_numbers, all_numbers[1:]))
    found: list[list[int]] = []
    for number in numbers:
        if found and following[found[-1][-1]] == number:
            found[-1].append(number)
        else:
            found.append([number])
    return [str(span[0]) if len(span) == 1 else f"{span[0]}-{span[-1]}" for span in found]


def enter(rows: list[Row], path: Path) -> None:
    """Write the table with the machine, the date and the commit."""
    whence = origin().split(",")
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *([*row, percent(row), *whence] for row in rows)])


if __name__ == "__main__":
    sys.exit(main())
