#!/usr/bin/env python3
"""Runs every test of mesocrete, Rust and Python, on a machine that has cargo and Python 3.10 or newer.

    python3 tests/run.py --quick    the quick tier: formatting, clippy, docs, and the Rust tests of a second or less
    python3 tests/run.py            set up .venv, build the wheel, cargo test, pytest
    python3 tests/run.py --slow     with the slow tier: long tests, every bench once, the release wheel, sanitizers
    python3 tests/run.py FILTER     one subject: write::lsdyna, collision::oracle, solve, test_gjk, test_gjk::test_touching

On two cores the tiers are meant to take 2, 9 and 60 minutes at the most; the quick one counts from a tree that is built.
Each needs the standard library alone, and reports at the end which tests failed, and which were skipped and why. The exit code is 0
when every stage passed.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
import venv
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tools"))
import arm64  # noqa: E402
from stage import ROOT, Ended, run, told_again

VENV = ROOT / ".venv"
# Room that the whole suite takes, in a fresh clone and where all is built.
FRESH_GB = 4
BUILT_GB = 1
# Programs that some Rust tests compare with; without them those tests skip. pytest names its own skips.
PEERS = {
    "ccx": "CalculiX solving our decks (Debian: calculix-ccx)",
    "gmsh": "gmsh reading our meshes (PyPI or Debian: gmsh)",
}

# Of the whole workspace, as the wheel is: other features would compile every crate a second time.
TESTED = ["--workspace", "--exclude", "meso-bench"]
# The slow tier has one profile for tests and benches, with every check of the crates that are built without, and a wheel of its own.
UNCHECKED = r"\[profile\.dev\.package\.(meso-\w+)\]\n(?:codegen-units = 1\n)?debug-assertions = false\noverflow-checks = true"
CORE = re.findall(UNCHECKED, (ROOT / "Cargo.toml").read_text(encoding="utf-8"))
assert len(CORE) >= 9, "Cargo.toml has profiles of crates that this expression does not find"
ASSERTING = (f"profile.dev.package.{crate}.debug-assertions=true" for crate in CORE)
WATCHED = ["--workspace", *(word for checks in ASSERTING for word in ("--config", checks))]

# What is said of a command, and the command.
Stage = tuple[str, list[str]]

# The workspace's command has devices, as the wheel needs them; a default build has none.
WITHOUT_DEVICES = ("the command without devices", ["cargo", "test", "-p", "meso-cli", "--test", "cli", "--", "no_devices"])

# Benches of conforming meshes.
GMSH_BENCHES = {"against_gmsh", "itz_layer"}

# Benches of the Python module; the solvers' leaves out what is not installed.
PYTHON_BENCHES = ["border.py", "cluster.py", "dataset.py", "effective.py", "effective_errors.py", "growth.py", "images.py", "label_volumes.py", "long_run.py", "memory.py", "mesh_write.py", "overheads.py", "rates.py", "recycled.py", "solver_error.py", "solvers.py", "stopping.py"]

# Subjects of the Rust tests that pack, mesh or solve for more than a second each; the quick tier leaves them out.
SLOW_SUBJECTS = [
    "calculix",
    "conforming",
    "cohesive_decks",
    "inclusions::",
    "interrupt",
    "matrix",
    "mesh",
    "offset::",
    "packing::",
    "periodic",
    "second_order",
    "solve",
    "specimens",
]


def main() -> int:
    """Run the stages in order and print what passed, failed and was skipped."""
    args = parse_args()
    started = time.monotonic()
    check_machine()
    if not (ROOT / "target" / "debug" / "incremental").exists():
        # Nobody has worked in this tree: what only the next change's build would use costs the first a seventh.
        os.environ.setdefault("CARGO_INCREMENTAL", "0")
    # gmsh's threads sleep where they wait for each other: on busy cores, waiting took a third of its processor time.
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    if args.filter:
        return summarise(in_turn(subject_stages(args.filter)), time.monotonic() - started)
    if args.quick:
        return summarise(in_turn(quick_stages()), time.monotonic() - started)
    if args.slow:
        # Of the properties: see tests/property.rs.
        os.environ["CASES"] = "new"
    python = make_venv()
    # Packages come over the network while the compiler works.
    with ThreadPoolExecutor() as beside:
        beside.submit(run, "cargo build of the tests", [*cargo_test(slow=args.slow), "--no-run", "--quiet"], live=False)
        install_packages(python)
    find_kernel_compilers()
    if not args.slow:
        must(*wheel(python))
    # The release wheel is linked on one core for minutes, so beside the tests.
    first = [*oldest_compiler(), *shipped_wheel(python)] if args.slow else []
    results = in_turn([*supply_chain(slow=args.slow), *packaging()])
    results += side_by_side(rust_stages(slow=args.slow), [*first, *python_stages(python, slow=args.slow)])
    if args.slow:
        results += in_turn([WITHOUT_DEVICES, *bench_stages(python), *watched_stages(python), *emulated_stages(python), *shipping(python)])
    return summarise(results, time.monotonic() - started)


def parse_args() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    tier = parser.add_mutually_exclusive_group()
    tier.add_argument("filter", nargs="?", metavar="FILTER", help="run one subject, by the path of its Rust tests or its file of Python tests")
    tier.add_argument("--quick", action="store_true", help="run the quick tier alone")
    tier.add_argument("--slow", action="store_true", help="run the slow tier, too")
    return parser.parse_args()


def check_machine() -> None:
    """Stop at once where Python, cargo or room on the disk are missing."""
    if sys.version_info < (3, 10):
        sys.exit(f"Python 3.10 or newer is needed; this is {sys.version.split()[0]}")
    if shutil.which("cargo") is None:
        sys.exit("cargo is not on the PATH; install Rust (https://rustup.rs) first")
    is_built = (ROOT / "target" / "debug").exists() and VENV.exists()
    needed = BUILT_GB if is_built else FRESH_GB
    free = shutil.disk_usage(ROOT).free / 1e9
    if free < needed:
        sys.exit(f"{free:.1f} GB are free on the disk of {ROOT}; the tests need {needed} GB. Delete something there first")


def make_venv() -> Path:
    """Make .venv with this interpreter and put its programs first on the PATH (maturin builds, gmsh meshes)."""
    python = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not python.exists():
        print(f"== making {VENV.name}", flush=True)
        try:
            venv.create(VENV, with_pip=True)
        except subprocess.CalledProcessError:
            shutil.rmtree(VENV, ignore_errors=True)
            sys.exit("Python cannot make a virtual environment with pip (Debian and Ubuntu: apt install python3-venv)")
    os.environ["PATH"] = os.pathsep.join([str(python.parent), os.environ.get("PATH", "")])
    os.environ["VIRTUAL_ENV"] = str(VENV)
    return python


def pip(python: Path) -> list[str]:
    """Name the command that installs packages."""
    return [str(python), "-m", "pip", "--disable-pip-version-check", "install", "--quiet", "--no-compile"]


def install_packages(python: Path) -> None:
    """Install what the tests need."""
    needed, optional = (str(ROOT / "tests" / f"requirements{which}.txt") for which in ("", "-optional"))
    # All in one go; one by one only where something cannot be had.
    if run(f"everything into {VENV.name}", [*pip(python), "-r", needed, "-r", optional]).code != 0:
        must(f"requirements into {VENV.name}", [*pip(python), "-r", needed])
        for package in read_requirements(Path(optional)):
            if run(package, [*pip(python), package]).code != 0:
                print(f"   {package}: not to be had here; the tests that need it skip", flush=True)


def find_kernel_compilers() -> None:
    """Point the tests of the GPU's kernels to NVRTC and ptxas, where their packages could be had."""
    folders = [str(path.parent) for path in sorted(VENV.glob("lib/python*/site-packages/nvidia/*/lib/libnvrtc.so.*"))]
    os.environ["LD_LIBRARY_PATH"] = os.pathsep.join([*folders, *filter(None, [os.environ.get("LD_LIBRARY_PATH")])])
    assemblers = sorted(VENV.glob("lib/python*/site-packages/nvidia/*/bin/ptxas"))
    os.environ.update({"PTXAS": str(path) for path in assemblers})


# A rebuilt wheel has the same version as the last one, so pip must be told to take it.
AGAIN = ["--force-reinstall", "--no-deps"]

# Where a release's wheel and source archive lie.
SHIPPED = ROOT / "target" / "shipped"


def wheel(python: Path) -> Stage:
    """Name the command that installs mesocrete in the tests' profile, compiled once for Rust and Python."""
    os.environ["MATURIN_PEP517_ARGS"] = "--profile dev"
    return "the wheel", [*pip(python), "--no-build-isolation", *AGAIN, str(ROOT)]


def shipped_wheel(python: Path) -> list[Stage]:
    """Name the commands that build the release's wheel and source archive, and install the wheel."""
    shutil.rmtree(SHIPPED, ignore_errors=True)
    return [
        ("release wheel", ["maturin", "build", "--release", "--sdist", "--out", str(SHIPPED)]),
        ("the wheel", [*pip(python), *AGAIN, "--no-index", "--find-links", str(SHIPPED), "mesocrete"]),
    ]


def read_requirements(path: Path) -> list[str]:
    """Read the packages a requirements file names."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def quick_stages() -> list[Stage]:
    """Name the commands of the quick tier; they need no Python package and no wheel."""
    skipped = [word for subject in SLOW_SUBJECTS for word in ("--skip", subject)]
    return [
        ("cargo fmt", ["cargo", "fmt", "--all", "--check"]),
        ("cargo clippy", ["cargo", "clippy", "--quiet", "--all-targets", "--", "--deny", "warnings"]),
        ("cargo clippy of devices", ["cargo", "clippy", "--quiet", "--all-targets", "-p", "meso-gpu", "-p", "meso-cli", "--features", "meso-cli/gpu", "--", "--deny", "warnings"]),
        ("cargo doc", ["cargo", "doc", "--no-deps", "--quiet", "--config", 'build.rustdocflags=["-D", "warnings"]']),
        ("collision alone", ["cargo", "check", "-p", "meso-collision"]),
        ("quick cargo test", [*cargo_test(slow=False), "--quiet", "--lib", "--tests", "--no-fail-fast", "--", *skipped]),
    ]


# Subjects of the Rust tests that share the binary `core`.
CORE_SUBJECTS = ("concrete", "pack", "mesh", "write")
PYTHON_TESTS = ROOT / "tests" / "python"


def subject_stages(wanted: str) -> list[Stage]:
    """Name the commands that test one subject, with the features of the whole suite, so that nothing is compiled twice."""
    file, _, name = wanted.partition("::")
    if (PYTHON_TESTS / f"{file.removesuffix('.py')}.py").exists():
        python = make_venv()
        install_packages(python)
        must(*wheel(python))
        tests = str(PYTHON_TESTS / f"{file.removesuffix('.py')}.py") + (f"::{name}" if name else "")
        return [("pytest", [str(python), "-m", "pytest", tests])]
    command = rust_subject(wanted)
    found = subprocess.run([*command, "--list"], cwd=ROOT, check=False, stdout=subprocess.PIPE, text=True)
    if found.returncode == 0 and not re.search(r": test$", found.stdout, re.MULTILINE):
        sys.exit(f"no test has `{wanted}` in its path; name a folder of tests/ with a file (write::lsdyna), or a file of tests/python (test_gjk)")
    return [(f"cargo test of {wanted}", command)]


def rust_subject(wanted: str) -> list[str]:
    """Build the command that runs the Rust tests of a subject: its binary where the first word names one, else all."""
    first, _, rest = wanted.partition("::")
    if first in CORE_SUBJECTS:
        return [*cargo_test(slow=False), "--test", "core", "--", f"{first}::{rest}"]
    if (ROOT / "tests" / first / "main.rs").exists():
        return [*cargo_test(slow=False), "--test", first, "--", *([rest] if rest else [])]
    return [*cargo_test(slow=False), "--lib", "--tests", "--", wanted]


# Stages that do not run here, each with the tool or the data that is missing.
SKIPPED: list[str] = []


def skip(what: str, missing: str) -> None:
    """Note a stage that cannot run here; the suite's last lines list all of them."""
    SKIPPED.append(f"skipped {what}: {missing}")


def supply_chain(*, slow: bool) -> list[Stage]:
    """Name the checks of dependencies. The slow tier installs their tool where it is missing."""
    tools = ROOT / "target" / "tools"
    os.environ["PATH"] = os.pathsep.join([os.environ["PATH"], str(tools / "bin")])
    if slow and shutil.which("cargo-deny") is None:
        run("cargo-deny", ["cargo", "install", "--quiet", "--locked", "--root", str(tools), "cargo-deny"])
    if shutil.which("cargo-deny") is None:
        skip("advisories, licences and sources of dependencies", "no cargo-deny; cargo install cargo-deny, or --slow")
        return []
    # Advisories need a database from the network; the other checks do without.
    fetched = subprocess.run(["cargo", "deny", "fetch", "db"], cwd=ROOT, check=False, capture_output=True).returncode == 0
    if not fetched:
        skip("advisories on dependencies", "their database could not be fetched")
    return [("cargo deny", ["cargo", "deny", "check", *(["advisories"] if fetched else []), "bans", "licenses", "sources"])]


def oldest_compiler() -> list[Stage]:
    """Name the check by the oldest compiler that is promised, where it is installed."""
    oldest = re.search(r'^rust-version = "(.*)"', (ROOT / "Cargo.toml").read_text(encoding="utf-8"), re.MULTILINE)[1]
    # As `1.89`, or with its patch as `1.89.0`.
    installed = re.search(rf"^{re.escape(oldest)}(\.\d+)?-\S+", toolchains(), re.MULTILINE)
    if not installed:
        skip("the oldest compiler promised", f"no Rust {oldest}; rustup toolchain install {oldest}")
        return []
    return [(f"Rust {oldest}", ["rustup", "run", installed[0], "cargo", "check", "--workspace", "--target-dir", "target/oldest"])]


def packaging() -> list[Stage]:
    """Name the checks of what is published: the crates' archives, and the workflows as far as their linter is to be had."""
    workspace = ["--workspace", "--exclude", "meso-py", "--exclude", "meso-bench"]
    found = [("cargo package", ["cargo", "package", "--quiet", "--no-verify", "--allow-dirty", *workspace])]
    lint = ["actionlint"] if shutil.which("actionlint") else ["go", "run", ACTIONLINT]
    if shutil.which(lint[0]) and subprocess.run([*lint, "-version"], check=False, capture_output=True).returncode == 0:
        found.append(("actionlint", lint))
    else:
        skip("the workflows themselves", "no actionlint, and no Go with modules to build it")
    return found


# Built by Go where the program itself is not installed.
ACTIONLINT = "github.com/rhysd/actionlint/cmd/actionlint@v1.7.12"


def shipping(python: Path) -> list[Stage]:
    """Name the commands that check the release's wheel and source archive, and install the wheel afresh."""
    clean = ROOT / "target" / "clean"
    programs = clean / ("Scripts" if os.name == "nt" else "bin")
    pip = [str(programs / "python"), "-m", "pip", "--disable-pip-version-check", "install", "--only-binary", ":all:"]
    stages = [
        ("an empty environment", [str(python), "-m", "venv", "--clear", str(clean)]),
        ("install from the wheel", [*pip, "--find-links", str(SHIPPED), "mesocrete"]),
        ("the installed command", [str(programs / "mesocrete"), "recipes"]),
    ]
    if subprocess.run([str(python), "-c", "import twine"], check=False, capture_output=True).returncode == 0:
        check = "import glob, sys, twine.__main__ as t; sys.argv = ['twine', 'check', '--strict', *glob.glob(sys.argv[1])]; sys.exit(t.main())"
        stages.insert(0, ("twine check", [str(python), "-c", check, str(SHIPPED / "*")]))
    else:
        skip("the metadata of wheel and source archive", "no twine")
    return stages


def rust_stages(*, slow: bool) -> list[Stage]:
    """Name the commands of Rust's tests, in order."""
    stages = [("cargo test", [*cargo_test(slow=slow), "--no-fail-fast", *(["--", "--include-ignored"] if slow else [])])]
    # The whole workspace has devices, since the wheel has them.
    alone = ("the command without devices", ["cargo", "test", "-p", "meso-cli", "--test", "cli", "no_devices"])
    return [*stages, *([alone] if slow else [])]


def cargo_test(*, slow: bool) -> list[str]:
    """Begin the command of Rust's tests."""
    return ["cargo", "test", *(WATCHED if slow else TESTED)]


# Leaves the types of other packages out, which stubtest would read for half a minute and not look at.
STUBTEST = ROOT / "tests" / "stubtest.ini"


def python_stages(python: Path, *, slow: bool) -> list[Stage]:
    """Name the commands of Python's tests, in order."""
    return [
        ("stubtest", [str(python), "-m", "mypy.stubtest", "mesocrete", "--mypy-config-file", str(STUBTEST)]),
        ("pytest", [str(python), "-m", "pytest", *(["--slow"] if slow else [])]),
    ]


def watched_stages(python: Path) -> list[Stage]:
    """Name what runs under a sanitizer: the fuzz targets, and the tests that pass through `unsafe`."""
    if shutil.which("cargo-fuzz") is None:
        skip("fuzz targets", "no cargo-fuzz; cargo install cargo-fuzz")
    fuzzing = ("fuzz targets", [str(python), str(ROOT / "fuzz" / "run.py"), "--seconds", "60", "--look"])
    if "nightly" not in toolchains():
        skip("`unsafe` under AddressSanitizer", "no nightly Rust; rustup toolchain install nightly")
        return [fuzzing]
    return [fuzzing, *((f"AddressSanitizer {target}", sanitized(crate, target)) for crate, target in UNSAFE)]


def emulated_stages(python: Path) -> list[Stage]:
    """Name the comparison with arm64 under emulation, where its tools are there."""
    wanted = arm64.missing()
    if wanted:
        skip("the bytes of arm64", f"no {'; '.join(wanted)}")
        return []
    return [("the bytes of arm64", [str(python), str(ROOT / "tools" / "arm64.py"), "--tests", *WATCHED[1:]])]


# What passes through `unsafe`: vector instructions and the hint to fetch memory in collision, registers in the solver.
UNSAFE = [("meso-collision", "collision"), ("meso-element", "laws"), ("meso-solve", "solve")]


def sanitized(crate: str, target: str) -> list[str]:
    """Build the command that runs a crate's tests under AddressSanitizer."""
    host = subprocess.run(["rustc", "-vV"], check=True, capture_output=True, text=True).stdout
    host = re.search(r"^host: (.*)$", host, re.MULTILINE)[1]
    build = ["--config", 'build.rustflags=["-Zsanitizer=address"]', "--target", host, "--target-dir", "target/sanitizer"]
    return ["rustup", "run", "nightly", "cargo", "test", "--quiet", *build, "-p", crate, "--test", target]


def toolchains() -> str:
    """List the toolchains of rustup, one a line; empty without rustup."""
    if shutil.which("rustup") is None:
        return ""
    return subprocess.run(["rustup", "toolchain", "list"], check=False, capture_output=True, text=True).stdout


def bench_stages(python: Path) -> list[Stage]:
    """Name the commands that run every bench once, on small cases; those that mesh with gmsh need it on the PATH."""
    if not has_gmsh():
        skip("benches of conforming meshes", "no gmsh")
    benches = [name for name in sorted((ROOT / "benches").glob("*.rs")) if has_gmsh() or name.stem not in GMSH_BENCHES]
    # In the profile of the tests: whether they run is asked, not how fast, and nothing is compiled again.
    rust = [["cargo", "bench", "--quiet", "--profile", "dev", *WATCHED, "--bench", name.stem, "--", "--quick"] for name in benches]
    scripts = [[str(python), str(ROOT / "benches" / name), "--quick"] for name in PYTHON_BENCHES]
    named = [(f"bench {name.stem}", command) for name, command in zip(benches, rust, strict=True)]
    return named + [(f"bench {Path(c[1]).stem}", c) for c in scripts]


def has_gmsh() -> bool:
    """Tell whether the conforming mesher's program is there."""
    return shutil.which("gmsh") is not None


def in_turn(stages: list[Stage], *, live: bool = True) -> list[Ended]:
    """Run stages one after another."""
    return [run(name, command, live=live) for name, command in stages]


def side_by_side(own: list[Stage], others: list[Stage]) -> list[Ended]:
    """Run two lists of stages at the same time: alone, each leaves a core idle behind its longest tests."""
    with ThreadPoolExecutor() as beside:
        found = beside.submit(in_turn, others, live=False)
        return in_turn(own) + found.result()


def must(what: str, command: list[str]) -> None:
    """Run a step of the set-up; the tests mean nothing without it."""
    if run(what, command).code != 0:
        sys.exit(f"the set-up failed at: {what}")


def summarise(stages: list[Ended], seconds: float) -> int:
    """Print the closing lines; 1 where a stage failed."""
    for program, what in PEERS.items():
        if shutil.which(program) is None:
            skip(what, f"no {program}")
    failed = [stage.name for stage in stages if stage.code != 0]
    for stage in stages:
        print(f"{'ok    ' if stage.code == 0 else 'FAILED'} {stage.name}: {stage.times}")
    # Last, since a log is often cut to its end.
    print(*told_again(stages), sep="\n", end="\n" if failed else "")
    print(*SKIPPED, sep="\n", end="\n" if SKIPPED else "")
    print(f"all stages in {seconds:.0f} s; {'failed: ' + ', '.join(failed) if failed else 'everything passed'}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
