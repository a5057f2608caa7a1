#!/usr/bin/env python3
"""Are arm64's files those of this machine, byte for byte? Builds the command for both, and runs arm64's under qemu.

    python3 tools/arm64.py                       # packings, meshes, an image, tests of a specimen
    python3 tools/arm64.py --tests               # and Rust tests of hulls, lockstep, laws, determinism
    python3 tools/arm64.py --built HERE ARM64    # of two programs that are there already

It needs Rust's library for arm64, a linker and an emulator:

    rustup target add aarch64-unknown-linux-gnu
    apt install gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user

Further arguments are cargo's, for both builds. The exit code is 0 when all files are the same.
"""

import argparse
import hashlib
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = "aarch64-unknown-linux-gnu"
LINKER = "aarch64-linux-gnu-gcc"
# Under these names cargo reads what links for arm64 and what runs it.
SETTINGS = f"CARGO_TARGET_{TARGET.upper().replace('-', '_')}_"

SPEC = """fraction = 0.3
seed = 1
specimen = { kind = 'cube', side_mm = 40 }
placement = { min_gap_mm = 1 }
[grading]
d_min_mm = 6
d_max_mm = 12
classes_mm = [6, 9, 12]
"""
COARSE = "--element-size-mm 5 --strain 0.002 --frames 2"
# Every method of meshing without gmsh, every law, and specimens of several kinds; names say what is in a file.
RUNS = [
    "pack --fraction 0.40 --seed 1 -o 40.json -o 40.vtu -o 40.inp -o 40.stl -o 40.csv -o 40.html",
    "pack --fraction 0.60 --seed 1 -o 60.json",
    "pack small.toml -o small.json",
    *(f"init {name} -o {name}.toml" for name in ("rve-60", "fibres-voids-100", "astm-cylinder-100")),
    *(f"pack {name}.toml -o {name}.json" for name in ("rve-60", "fibres-voids-100", "astm-cylinder-100")),
    "mesh small.json --method voxel -o voxel.vtu -o voxel.inp",
    "mesh small.json --method lattice --element-size-mm 2 -o fitted.vtu -o fitted.inp",
    "mesh small.json --method lattice --element-size-mm 2 --fit plain -o plain.vtu",
    "mesh small.json --method lattice --element-size-mm 1.5 --itz solid -o solid.vtu",
    "mesh small.json --method lattice --element-size-mm 2 --itz cohesive -o cohesive.inp",
    "mesh rve-60.json --method lattice --element-size-mm 4 --itz none -o periodic.inp",
    "image small.json -o image.npy",
    f"solve small.json -o cdp {COARSE}",
    f"solve small.json -o meso --law meso {COARSE}",
    f"solve small.json -o cdpm2 --law cdpm2 {COARSE}",
    f"solve small.json -o unsmoothed --smoothing none {COARSE}",
    f"solve small.json -o cohesive --itz cohesive {COARSE}",
    f"solve small.json -o voxels --method voxel --test tension {COARSE}",
]

# What compares vectors, exact answers and bytes.
TESTS = [
    ["-p", "meso-collision", "--lib"],
    ["-p", "meso-collision", "--test", "collision", "--", "batches::", "packed::", "hull::"],
    ["-p", "meso-element", "--test", "laws"],
    ["-p", "meso-solve", "--test", "solve", "--", "determinism::"],
]


def main() -> int:
    """Build, run and compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tests", action="store_true", help="run Rust tests under qemu, too")
    parser.add_argument("--built", nargs=2, metavar=("HERE", "ARM64"), help="compare these programs; build nothing")
    args, cargo = parser.parse_known_args()
    wanted = missing(cargo_too=not args.built or args.tests)
    if wanted:
        sys.exit(f"wanted: {'; '.join(wanted)}")
    os.environ.update(settings())
    here, arm64 = map(os.path.abspath, args.built) if args.built else (build(cargo), build([*cargo, "--target", TARGET]))
    different = compare([here], [*emulator(), arm64])
    failed = [test for test in TESTS if args.tests and not passes(test, cargo)]
    return 1 if different or failed else 0


def missing(*, cargo_too: bool = True) -> list[str]:
    """Name what this machine lacks, and how to get it."""
    found = {
        "an x86-64 machine to compare with": platform.machine() in {"x86_64", "AMD64"},
        "qemu-aarch64 (Debian: qemu-user)": emulator(),
    }
    if cargo_too:
        found[f"Rust's library for arm64 (rustup target add {TARGET})"] = (sysroot() / "lib/rustlib" / TARGET / "lib").exists()
        found[f"{LINKER} (Debian: gcc-aarch64-linux-gnu)"] = shutil.which(os.environ.get(f"{SETTINGS}LINKER", LINKER))
    return [what for what, there in found.items() if not there]


def sysroot() -> Path:
    """Find where the compiler's libraries lie."""
    return Path(subprocess.run(["rustc", "--print", "sysroot"], check=True, capture_output=True, text=True).stdout.strip())


def emulator() -> list[str]:
    """Name the command that runs a program of arm64; empty where there is none."""
    found = shutil.which("qemu-aarch64") or shutil.which("qemu-aarch64-static")
    return [found] if found else []


def settings() -> dict[str, str]:
    """Name linker, runner and libraries of arm64, as far as the environment does not."""
    usual = {f"{SETTINGS}LINKER": LINKER, f"{SETTINGS}RUNNER": " ".join(emulator()), "QEMU_LD_PREFIX": "/usr/aarch64-linux-gnu"}
    return {name: os.environ.get(name, value) for name, value in usual.items()}


def build(cargo: list[str]) -> str:
    """Build the command; its path."""
    # Of the whole workspace, as the tests are: other features would compile every crate a second time.
    program = ["--workspace", "--bin", "mesocrete"]
    command = ["cargo", "build", "--quiet", "--message-format", "json-render-diagnostics", *program, *cargo]
    built = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    messages = [json.loads(line) for line in built.splitlines()]
    return next(message["executable"] for message in messages if message.get("executable"))


def passes(test: list[str], cargo: list[str]) -> bool:
    """Run Rust tests under qemu."""
    command = ["cargo", "test", "--quiet", "--target", TARGET, *cargo, *test]
    return subprocess.run(command, cwd=ROOT, check=False).returncode == 0


def compare(here: list[str], arm64: list[str]) -> list[str]:
    """Let both programs do all runs; the files that differ."""
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor() as beside:
        ours, theirs = beside.map(files, [Path(folder) / "here", Path(folder) / "arm64"], [here, arm64])
    different = sorted(name for name in ours.keys() | theirs.keys() if ours.get(name) != theirs.get(name))
    for name in different:
        print(f"{'differs' if name in ours and name in theirs else 'is there once'}: {name}")
    print(f"{len(ours) - len(different)} of {len(ours)} files are the same on arm64")
    return different


def files(folder: Path, program: list[str]) -> dict[str, str]:
    """Do all runs in a new folder; the digest of each file in it."""
    folder.mkdir()
    (folder / "small.toml").write_text(SPEC, encoding="utf-8")
    for run in RUNS:
        subprocess.run([*program, *run.split(), "--quiet"], cwd=folder, check=True, stderr=subprocess.DEVNULL)
    found = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(content(path)).hexdigest() for path in found}


def content(path: Path) -> bytes:
    """Read a file, without the times that a result names."""
    if path.name != "result.json":
        return path.read_bytes()
    result = json.loads(path.read_bytes())
    del result["seconds"]
    return json.dumps(result).encode()


if __name__ == "__main__":
    sys.exit(main())
