"""The package itself: what it names, what importing it does."""

import importlib.metadata
import pickle
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

import mesocrete as mc


ROOT = Path(__file__).resolve().parents[2]


def python(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True).stdout


def test_every_public_name_is_there_and_documented():
    for name in mc.__all__:
        assert getattr(mc, name).__doc__, name
    for name in mc.gjk.__all__:
        assert getattr(mc.gjk, name).__doc__, name


def test_version_is_that_of_the_installed_package():
    assert mc.__version__ == importlib.metadata.version("mesocrete")


def test_types_are_shipped():
    folder = Path(mc.__file__).parent
    assert (folder / "py.typed").exists()
    assert (folder / "_mesocrete.pyi").exists()


def test_import_prints_nothing_and_starts_no_thread():
    code = (
        "import os, signal, threading, numpy; before = len(os.listdir('/proc/self/task'));"
        "handler = signal.getsignal(signal.SIGINT); import mesocrete;"
        "assert signal.getsignal(signal.SIGINT) is handler;"
        "assert len(os.listdir('/proc/self/task')) == before"
    )
    if sys.platform != "linux":
        code = "import mesocrete"
    assert python(code) == ""


def test_import_takes_less_than_50_ms():
    code = "import time; t = time.process_time(); import mesocrete; print(time.process_time() - t)"
    assert min(float(python(code)) for _ in range(3)) < 0.05


def test_first_use_takes_less_than_50_ms_beyond_numpy():
    code = "import numpy, time; t = time.process_time(); import mesocrete; mesocrete.pack; print(time.process_time() - t)"
    assert min(float(python(code)) for _ in range(3)) < 0.05


def test_numpy_is_imported_with_the_first_name_and_not_by_the_command():
    code = "import sys, mesocrete; a = 'numpy' in sys.modules; mesocrete.Polyhedron; print(a, 'numpy' in sys.modules)"
    assert python(code) == "False True\n"
    code = "import sys, mesocrete.__main__; print('numpy' in sys.modules)"
    assert python(code) == "False\n"


def test_every_name_is_found_on_first_use():
    for name in mc.__all__:
        assert python(f"from mesocrete import {name}; import mesocrete; print('{name}' in dir(mesocrete))") == "True\n"
    with pytest.raises(AttributeError, match="module 'mesocrete' has no attribute 'Packings'"):
        mc.Packings


def test_pickles_are_read_where_nothing_is_imported_yet(packing, tmp_path):
    """What pickle calls makes arrays, and must load numpy for it."""
    path = tmp_path / "packing.pickle"
    path.write_bytes(pickle.dumps([packing, packing.aggregates[0], packing.aggregates[0].body]))
    code = f"import pickle; p, a, b = pickle.load(open({str(path)!r}, 'rb')); print(p.table()['id'][0], a.id, len(b.vertices) > 3)"
    assert python(code) == "0 0 True\n"


def test_import_does_not_pull_in_the_optional_libraries():
    code = "import sys, mesocrete; print([m for m in ('pyvista', 'meshio', 'matplotlib', 'gmsh') if m in sys.modules])"
    assert python(code) == "[]\n"


def test_aggregates_are_a_sequence():
    assert issubclass(mc.Aggregates, Sequence)


def test_classes_name_the_package_they_are_imported_from():
    for name in ("Aggregate", "Mesh", "Packing", "Polyhedron", "Spec"):
        assert getattr(mc, name).__module__ == "mesocrete"


def test_the_wheel_and_the_rust_tests_share_their_crates():
    """Another feature in either, and everything is compiled twice."""
    if shutil.which("cargo") is None:
        pytest.skip("no cargo here")

    def features(*selected):
        tree = ["cargo", "tree", "--quiet", "--prefix", "none", "--format", "{p} {f}", "--edges", *selected]
        lines = subprocess.run(tree, cwd=ROOT, capture_output=True, text=True, timeout=60, check=True).stdout.splitlines()
        return {line.removesuffix(" (*)") for line in lines}

    assert features("normal,build", "-p", "meso-py") <= features("normal,build,dev", "--workspace", "--exclude", "meso-bench")


def crates(*selected):
    """The names of the crates that a build of the selected packages compiles into them."""
    if shutil.which("cargo") is None:
        pytest.skip("no cargo here")
    tree = ["cargo", "tree", "--quiet", "--prefix", "none", "--format", "{p}", "--edges", "normal", *selected]
    lines = subprocess.run(tree, cwd=ROOT, capture_output=True, text=True, timeout=60, check=True).stdout.splitlines()
    return {line.split()[0] for line in lines if line}


def test_a_default_build_has_no_crate_for_devices_and_the_wheel_has_two():
    command, with_devices = crates("-p", "meso-cli"), crates("-p", "meso-cli", "--features", "gpu")
    assert with_devices - command == {"meso-gpu", "libloading"}
    assert not crates() & {"meso-gpu", "libloading"} and crates() >= command
    assert with_devices < crates("-p", "meso-py")


def test_the_library_names_no_driver_of_a_gpu():
    """Drivers are opened when `device` asks. The command of the wheel is the same library."""
    if sys.platform != "linux" or shutil.which("readelf") is None:
        pytest.skip("no readelf here (Debian: binutils)")
    library = Path(mc.__file__).parent.glob("_mesocrete*.so")
    dynamic = ["readelf", "--dynamic", "--wide", str(next(library))]
    section = subprocess.run(dynamic, capture_output=True, text=True, timeout=60, check=True).stdout
    needed = [line.split("[")[1].rstrip("]") for line in section.splitlines() if "(NEEDED)" in line]
    assert "libc.so.6" in needed
    assert [name for name in needed if re.search("opencl|cuda|nvrtc", name, re.IGNORECASE)] == []


def test_every_published_crate_names_the_page_of_its_documentation():
    published = 0
    for manifest in sorted((ROOT / "crates").glob("*/Cargo.toml")):
        text = manifest.read_text(encoding="utf-8")
        if "publish = false" not in text:
            assert f'documentation = "https://docs.rs/{manifest.parent.name}"\n' in text, manifest
            published += 1
    assert published == 19
