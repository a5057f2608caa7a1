"""tests/run.py names again, at its end, the tests that failed: a log is often cut to its last lines."""

import importlib.util
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def stage():
    """The part of tests/run.py that runs one command."""
    spec = importlib.util.spec_from_file_location("stage", TESTS / "stage.py")
    module = importlib.util.module_from_spec(spec)
    # Dataclasses look their module up.
    sys.modules["stage"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def suite(stage):
    """The program tests/run.py."""
    sys.path.insert(0, str(TESTS))
    try:
        spec = importlib.util.spec_from_file_location("run", TESTS / "run.py")
        spec.loader.exec_module(module := importlib.util.module_from_spec(spec))
    finally:
        sys.path.remove(str(TESTS))
    return module


@pytest.mark.parametrize(
    ("wanted", "end"),
    [
        ("write::lsdyna", ["--test", "core", "--", "write::lsdyna"]),
        ("pack", ["--test", "core", "--", "pack::"]),
        ("collision::oracle", ["--test", "collision", "--", "oracle"]),
        ("solve", ["--test", "solve", "--"]),
        ("saved", ["--lib", "--tests", "--", "saved"]),
    ],
)
def test_a_subject_is_tested_with_the_features_of_the_suite(suite, wanted, end):
    """The case: `cargo test -p meso-cli` compiled every crate a second time."""
    assert suite.rust_subject(wanted) == ["cargo", "test", "--workspace", "--exclude", "meso-bench", *end]


CARGO = """
test hull::a ... FAILED
failures:

---- hull::a stdout ----
thread 'hull::a' panicked at tests/core/hull.rs:1:1:

failures:
    hull::a
    offset::b

test result: FAILED. 7 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.00s

\x1b[1m\x1b[91merror\x1b[0m: test failed, to rerun pass `-p meso-core --test core`
"""
PYTEST = """
ERROR    root:x.py:7 a line of a log
=========================== short test summary info ============================
SKIPPED [1] tests/python/test_bar.py:5: could not import 'x'
FAILED tests/python/test_gjk.py::test_touching - assert 1 == 2
ERROR tests/python/test_site.py - ImportError: mkdocs
"""


@pytest.mark.parametrize(
    ("printed", "named"),
    [
        (CARGO, ["hull::a", "offset::b", "error: test failed, to rerun pass `-p meso-core --test core`"]),
        (PYTEST, ["FAILED tests/python/test_gjk.py::test_touching - assert 1 == 2", "ERROR tests/python/test_site.py - ImportError: mkdocs"]),
        ("\n".join(map(str, range(9))), ["4", "5", "6", "7", "8"]),
    ],
    ids=["cargo", "pytest", "neither"],
)
def test_the_tests_that_failed_are_named(stage, capfd, printed, named):
    ended = stage.run("a stage", [sys.executable, "-c", f"print({printed!r}); raise SystemExit(3)"])
    assert (ended.code, ended.failures) == (3, named)
    shown = capfd.readouterr().out
    assert printed in shown
    assert "== a stage: FAILED (3) in " in shown


def test_a_stage_that_passed_names_no_test(stage):
    assert stage.run("a stage", [sys.executable, "-c", "print('error: expected')"]).failures == []


def test_the_end_has_room_for_every_stage(stage):
    ended = [stage.Ended(name, code, 1.0, None, ["name"] * 30) for name, code in (("x", 1), ("y", 0), ("z", 101))]
    lines = stage.told_again(ended)
    assert lines[0] == "failed in x:"
    assert lines[11:13] == ["    ... and 20 more", "failed in z:"]
    assert len(lines) == 24
