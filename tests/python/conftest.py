"""What several test files share: the small packing they look at, the tiers, and the command."""

import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import settings

import mesocrete as mc

# A sixtieth of the paper's specimen: packs in a moment, and still has all three size classes.
SMALL = {"specimen": {"kind": "cube", "side_mm": 60.0}, "fraction": 0.35}


def pytest_addoption(parser):
    parser.addoption("--slow", action="store_true", help="run the slow tier, too")


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: takes minutes; runs with --slow")
    # The slow tier draws new cases each time; the whole suite takes the same ones, so that it fails for a change alone.
    settings.register_profile("same", derandomize=True)
    settings.load_profile("default" if config.getoption("--slow") else "same")
    # Shells start what runs in the background deaf to Ctrl-C, which some tests send.
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(config, items):
    if not config.getoption("--slow"):
        for item in items:
            if "slow" in item.keywords:
                item.add_marker(pytest.mark.skip(reason="slow tier: pytest --slow"))


@pytest.fixture(scope="session")
def small_spec():
    return SMALL


@pytest.fixture(scope="session")
def packing():
    return mc.pack(SMALL, seed=7)


@pytest.fixture
def gmsh():
    """gmsh, ready to open a file and silent."""
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize(interruptible=False)
    # gmsh lets a broken pipe end the process without a word, as the one to a worker that another test kills.
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh
    gmsh.finalize()


@pytest.fixture(scope="session")
def command():
    """The installed `mesocrete`, which the wheel put beside this interpreter."""
    beside = Path(sys.executable).with_name("mesocrete")
    found = str(beside) if beside.exists() else shutil.which("mesocrete")
    assert found, "the wheel did not install the mesocrete command"
    return found


@pytest.fixture
def run(command, tmp_path):
    """Runs the command in an empty folder and returns the finished process."""

    def run_command(*args, **options):
        options = {"capture_output": True, "text": True, "timeout": 300, "cwd": tmp_path} | options
        return subprocess.run([command, *map(str, args)], **options)

    return run_command
