"""tools/coverage.py reads what llvm-cov exports and leaves tests out; the figures in the documents are those of its last table."""

import csv
import importlib.util
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# A crate of four files, and what llvm-cov 22 exported of its own unit tests (`--format=lcov`, without mangled names).
SOURCES = {
    "lib.rs": """\
mod ways;
pub mod size;

pub fn larger(a: i32, b: i32) -> i32 {
    if a > b {
        return a;
    }
    b
}

#[cfg(test)]
fn two() -> i32 {
    2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_is_larger() {
        assert_eq!(larger(1, two()), 2);
        assert_eq!(ways::double(4), 8);
    }
}
""",
    "size.rs": "pub fn unused() -> i32 {\n    3\n}\n",
    "ways/mod.rs": """\
#[cfg(test)]
mod trial;

#[cfg_attr(not(test), allow(dead_code))]
pub(crate) fn double(a: i32) -> i32 {
    if a < 0 {
        let positive = -a;

        return -double(positive);
    }
    a + a
}
""",
    "ways/trial.rs": "#[test]\nfn doubles() {\n    assert_eq!(super::double(1), 2);\n}\n",
}
EXPORT = """\
SF:ROOT/crates/meso-x/src/lib.rs
FN:12,two
FN:4,larger
FNDA:1,two
FNDA:1,larger
FNF:3
FNH:3
DA:4,1
DA:5,1
DA:6,0
DA:7,1
DA:8,1
DA:9,1
DA:12,1
DA:13,1
DA:14,1
DA:21,1
DA:22,1
DA:23,1
DA:24,1
BRF:0
BRH:0
LF:13
LH:12
end_of_record
SF:ROOT/crates/meso-x/src/size.rs
DA:1,0
DA:2,0
DA:3,0
LF:3
LH:0
end_of_record
SF:ROOT/crates/meso-x/src/ways/mod.rs
DA:5,2
DA:6,2
DA:7,0
DA:9,0
DA:10,2
DA:11,2
DA:12,2
LF:7
LH:5
end_of_record
SF:ROOT/crates/meso-x/src/ways/trial.rs
DA:2,1
DA:3,1
DA:4,1
LF:3
LH:3
end_of_record
SF:/registry/src/nalgebra/src/lib.rs
DA:1,5
end_of_record
SF:ROOT/tests/x/main.rs
DA:1,1
end_of_record
"""


@pytest.fixture(scope="module")
def coverage():
    """The script, by a name that is not that of the package `coverage`."""
    tests = str(ROOT / "tests")
    sys.path.insert(0, tests)
    try:
        spec = importlib.util.spec_from_file_location("line_coverage", ROOT / "tools" / "coverage.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(tests)
    return module


@pytest.fixture(scope="module")
def counts(coverage, tmp_path_factory):
    """The lines of the small crate that are no tests."""
    root = tmp_path_factory.mktemp("root")
    for name, text in SOURCES.items():
        path = root / "crates" / "meso-x" / "src" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return coverage.own_lines(coverage.read_lcov(EXPORT.replace("ROOT", str(root))), root)


def test_lines_are_those_of_the_crate_without_its_tests(counts):
    assert {name.removeprefix("crates/meso-x/src/"): sorted(lines) for name, lines in counts.items()} == {
        "lib.rs": [4, 5, 6, 7, 8, 9],
        "size.rs": [1, 2, 3],
        "ways/mod.rs": [5, 6, 7, 9, 10, 11, 12],
    }


def test_the_table_sums_up_crates_and_folders(coverage, counts):
    rows = coverage.table(counts)
    assert rows == [("meso-x", 16, 10), ("meso-x/src", 9, 5), ("meso-x/ways", 7, 5)]
    assert coverage.shown(rows).splitlines()[1].split() == ["meso-x", "16", "10", "62.5"]


def test_a_file_beside_its_folder_counts_with_it(coverage):
    names = [f"crates/meso-x/src/{name}.rs" for name in ("check", "check/pairs", "stop")]
    rows = coverage.table({name: {1: 1} for name in names})
    assert rows == [("meso-x", 3, 3), ("meso-x/check", 2, 2), ("meso-x/src", 1, 1)]


def test_lines_that_no_test_runs_are_listed(coverage, counts):
    # Nothing with code stands between 7 and 9.
    assert coverage.missing(counts, "meso-x/ways") == ["crates/meso-x/src/ways/mod.rs: 2 of 7: 7-9"]
    assert coverage.missing(counts, "meso-x/src")[0] == "crates/meso-x/src/lib.rs: 1 of 6: 6"
    assert coverage.missing({}, "meso-x/ways") == ["meso-x/ways: no line is missing"]


def test_without_the_tools_the_message_says_how_to_get_them(coverage, monkeypatch, tmp_path):
    monkeypatch.setattr(coverage, "output", lambda command: "host: x86_64-unknown-none\n" if "-vV" in command else f"{tmp_path}\n")
    with pytest.raises(SystemExit, match="rustup component add llvm-tools"):
        coverage.find_tools()


def test_the_table_is_entered_with_its_origin(coverage, counts, tmp_path):
    coverage.enter(coverage.table(counts), tmp_path / "coverage.csv")
    rows = read(tmp_path / "coverage.csv")
    assert [row["percent"] for row in rows] == ["62.5", "55.6", "71.4"]
    assert all(row["machine"] and row["date"] and row["commit"] for row in rows)


def test_the_documents_have_the_figures_of_the_table():
    rows = {row["what"]: row for row in read(ROOT / "benches" / "results" / "coverage.csv")}
    text = (ROOT / "docs" / "guarantees.md").read_text(encoding="utf-8")
    (row,) = [line for line in text.splitlines() if "`python3 tools/coverage.py`" in line]
    for crate, percent, lines in re.findall(r"`(meso-\w+)` ([\d.]+) % of ([\d,]+)", row):
        assert (rows[crate]["percent"], rows[crate]["lines"]) == (percent, lines.replace(",", "")), crate
    folders = re.findall(r"`(meso-\w+/\w+)` \(([\d.]+) %\)", row)
    assert {"meso-collision", "meso-core"} <= {crate for crate, *_ in re.findall(r"`(meso-\w+)` ([\d.]+) %", row)} and folders
    assert [(folder, rows[folder]["percent"]) for folder, _ in folders] == folders


def read(path: Path) -> list[dict[str, str]]:
    """Read a table."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
