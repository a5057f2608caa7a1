"""Diffusivity and stiffness of one label image by mesocrete and by other programs: CPU time against error.

    python3 benches/effective.py [PROGRAM]      # enters benches/results/effective_peers.csv

`--quick` solves small images and enters nothing.

Needs taufactor, porespy (with openpnm and pyamg) and muSpectre; one that is not there is left out. Each solution has a process of
its own, on two threads; the least CPU time of five runs counts. Times of the others are those of the solution alone: imports and
reading are subtracted by a run without it. The error is relative to the value that the same program reaches at its tightest
tolerance: programs differ by their conditions at the faces, and so by 1 % in the value. Images have odd edges, since muSpectre
takes no others.
"""

import json
import os
import subprocess
import sys
import tempfile
import textwrap
import time
from pathlib import Path

from origin import RESULTS, origin

TABLE = RESULTS / "effective_peers.csv"
HEADER = "property,program,tolerance,voxels,value,relative_error,wall_s,cpu_s,peak_mb,machine,date,commit"
SPEC = """fraction = 0.5
seed = 1
specimen = { kind = "cube", side_mm = 60, periodic = ["x", "y", "z"] }
grading = { d_min_mm = 5, d_max_mm = 20 }
"""
# Mortar conducts, aggregates and their ITZ do not; all of them are elastic.
PHASES = """[diffusivity]
0 = 1.0
1 = 0.0
[stiffness.0]
youngs_modulus_mpa = 20000
poisson_ratio = 0.2
[stiffness.1]
youngs_modulus_mpa = 60000
poisson_ratio = 0.2
"""
# `binary` is True in the aggregates; each prints the value.
TAUFACTOR = """
    import torch, taufactor
    torch.set_num_threads(2)
    if solve:
        solver = taufactor.Solver((~binary).transpose(2, 1, 0).astype(np.uint8), device="cpu")
        solver.solve(iter_limit=100_000, verbose=False, conv_crit=tolerance)
        print(float(np.ravel(solver.D_eff)[0]))
"""
PORESPY = """
    import openpnm, pyamg, porespy
    if solve:
        found = porespy.simulations.tortuosity_fd(~binary, axis=2, tol=tolerance)
        print(1 / found.formation_factor)
"""
MUSPECTRE = """
    import muSpectre as msp
    if solve:
        cell = msp.Cell(list(binary.shape), [1.0] * 3, msp.Formulation.small_strain)
        elastic = msp.material.MaterialLinearElastic1_3d
        phases = [elastic.make(cell, "mortar", 20000.0, 0.2), elastic.make(cell, "aggregate", 60000.0, 0.2)]
        # Its first axis is x, which varies fastest in its order of pixels.
        for pixel, inside in enumerate(binary.ravel().tolist()):
            phases[inside].add_pixel(pixel)
        cell.initialise()
        krylov = msp.solvers.KrylovSolverCG(cell, tolerance, 1000, msp.Verbosity.Silent)
        strain = np.diag([1e-3, 0, 0])
        result = msp.solvers.newton_cg(cell, strain, krylov, tolerance, tolerance, msp.Verbosity.Silent)
        print(float(np.asarray(result.stress).reshape(-1, 9)[:, 0].mean() / 1e-3))
"""
PROGRAMS = {
    "taufactor": ("diffusivity", TAUFACTOR, [1e-2, 1e-3, 1e-4]),
    "porespy": ("diffusivity", PORESPY, [1e-5, 1e-8]),
    "muSpectre (one strain)": ("stiffness", MUSPECTRE, [1e-3, 1e-6]),
}


def measure(command):
    """Run a command; its output, wall and CPU seconds, peak memory in MB. None where it fails."""
    start = time.perf_counter()
    with tempfile.TemporaryFile() as out:
        process = subprocess.Popen(command, stdout=out, stderr=subprocess.DEVNULL, env={**os.environ, "OMP_NUM_THREADS": "2"})
        _, status, used = os.wait4(process.pid, 0)
        out.seek(0)
        text = out.read().decode()
    figures = [time.perf_counter() - start, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024 / 1e6]
    return (text, *figures) if status == 0 else None


def best(command, runs=5):
    """Run a command several times; the run of the least CPU time."""
    found = [measure(command) for _ in range(1 if "--quick" in sys.argv else runs)]
    return None if None in found else min(found, key=lambda run: run[2])


def script(body, tolerance, image, solve):
    head = f"import numpy as np\nbinary = np.load({str(image)!r}) > 0\ntolerance, solve = {tolerance}, {solve}\n"
    return [sys.executable, "-c", head + textwrap.dedent(body)]


def peers(image, what, voxels):
    """Yield the rows of the other programs that have a property."""
    for name, (their, body, tolerances) in PROGRAMS.items():
        if their != what:
            continue
        empty = best(script(body, 0, image, solve=False))
        if empty is None:
            print(f"{name} is not installed; it is left out", file=sys.stderr)
            continue
        found = []
        for tolerance in tolerances:
            run = best(script(body, tolerance, image, solve=True))
            if run is None:
                print(f"{name} failed at {tolerance}", file=sys.stderr)
                continue
            text, wall, cpu, peak = run
            found.append((tolerance, float(text.split()[-1]), wall - empty[1], cpu - empty[2], peak))
            print(name, *found[-1], flush=True)
        yield from rows(what, name, voxels, found)


def rows(what, name, voxels, found):
    """Yield a row for each tolerance; the last one is the tightest."""
    for tolerance, value, wall, cpu, peak in found:
        error = abs(value / found[-1][1] - 1)
        yield f"{what},{name},{tolerance},{voxels},{value:.8g},{error:.1e},{wall:.2f},{cpu:.2f},{peak:.0f},{origin()}"


def own(program, image, phases, what, voxels):
    """Yield the rows of mesocrete: the whole process with all its solutions, those on the coarse image too."""
    axes, tolerances = (["--axes", "x"], [1e-4, 1e-5, 1e-9]) if what == "diffusivity" else (["--periodic", "xyz"], [1e-6, 1e-12])
    found = []
    for tolerance in tolerances:
        with tempfile.TemporaryDirectory() as folder:
            flags = ["--what", what, "--phases", str(phases), "--no-fields", "--quiet", "--threads", "2", "-o", folder]
            run = best([program, "effective", str(image), *axes, *flags, "--tolerance", str(tolerance), "--force"])
            value = json.loads((Path(folder) / "effective.json").read_text())["fine"][0][0]
        found.append((tolerance, value, *run[1:]))
    yield from rows(what, "mesocrete" if what == "diffusivity" else "mesocrete (six strains)", voxels, found)


def label_image(program, folder, voxels):
    """Make an image: 1 in the aggregates with their ITZ, else 0."""
    spec, model, image = (Path(folder) / name for name in ["s.toml", "m.json", f"labels_{voxels}.npy"])
    spec.write_text(SPEC)
    subprocess.run([program, "pack", spec, "-o", model, "--quiet", "--force"], check=True)
    subprocess.run([program, "image", model, "-o", image, "--voxel-size-mm", str(60 / voxels), "--quiet"], check=True)
    binary = ["import numpy as np", f"name = {str(image)!r}", "np.save(name, (np.load(name) > 0).astype('uint8'))"]
    subprocess.run([sys.executable, "-c", "\n".join(binary)], check=True)
    return image


def main():
    quick = "--quick" in sys.argv
    named = [word for word in sys.argv[1:] if word != "--quick"]
    beside = Path(sys.executable).with_name("mesocrete")
    program = named[0] if named else str(beside) if beside.exists() else "mesocrete"
    lines = [HEADER]
    with tempfile.TemporaryDirectory() as folder:
        phases = Path(folder) / "p.toml"
        phases.write_text(PHASES)
        for what, voxels in [("diffusivity", 21 if quick else 99), ("stiffness", 9 if quick else 49)]:
            image = label_image(program, folder, voxels)
            for row in own(program, image, phases, what, voxels):
                lines.append(row)
                print(row, flush=True)
            lines.extend(peers(image, what, voxels))
            if not quick:
                TABLE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
