"""How long meshes of ten million elements take to write, alone, and the most memory the process had.

    python3 benches/mesh_write.py        # with the mesocrete wheel installed; enters benches/results/mesh_write.csv

The paper's specimen, without ITZ: hexahedra of 0.69 mm, tetrahedra of a plain lattice of 1.6 mm; and, for LS-DYNA, the six
million tetrahedra of a fitted lattice of 2 mm. Files go to the temporary
folder and are removed. Each format has a process of its own, so that its peak is its own. `--quick` writes meshes of some
ten thousand elements and enters nothing.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import mesocrete as mc
from origin import RESULTS, origin

TABLE = RESULTS / "mesh_write.csv"
HEADER = "method,elements,format,file_mb,wall_s,cpu_s,peak_mb,peak_before_mb,machine,date,commit"
PLAIN = {"method": "lattice", "fit": "plain"}
MESHES = {"voxel": {"element_size": 0.69}, "lattice": PLAIN | {"element_size": 1.6}, "fitted": {"method": "lattice", "element_size": 2}}
QUICK = {"voxel": {"element_size": 6}, "lattice": PLAIN | {"element_size": 10}, "fitted": {"method": "lattice", "element_size": 10}}
FORMATS = {"voxel": ["inp", "vtu", "pvtu", "msh"], "lattice": ["inp", "vtu", "pvtu", "msh"], "fitted": ["k"]}


def cpu_seconds():
    used = os.times()
    return used.user + used.system


def peak_mb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6


def row(model, method, extension, quick):
    sizes = QUICK if quick == "--quick" else MESHES
    mesh = mc.load(model).mesh(itz="none", accept_phase_error=True, **sizes[method])
    before = peak_mb()
    with tempfile.TemporaryDirectory() as folder:
        start, used = time.perf_counter(), cpu_seconds()
        mesh.write(Path(folder) / f"mesh.{extension}")
        wall, cpu, peak = time.perf_counter() - start, cpu_seconds() - used, peak_mb()
        size = sum(file.stat().st_size for file in Path(folder).iterdir()) / 1e6
    return f"{method},{len(mesh.cells)},{extension},{size:.0f},{wall:.1f},{cpu:.1f},{peak:.0f},{before:.0f},{origin()}"


def main():
    quick = "--quick" in sys.argv
    with tempfile.TemporaryDirectory() as folder:
        model = str(Path(folder) / "model.json")
        mc.pack(seed=1).write(model)
        lines = [HEADER]
        for method in MESHES:
            for extension in FORMATS[method]:
                run = [sys.executable, __file__, model, method, extension, "--quick" if quick else "--all"]
                lines.append(subprocess.run(run, check=True, capture_output=True, text=True).stdout.strip())
                print(lines[-1], flush=True)
    if not quick:
        TABLE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    if len(sys.argv) == 5:
        print(row(*sys.argv[1:]))
    else:
        main()
