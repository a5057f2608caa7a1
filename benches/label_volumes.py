"""What a label volume of 256^3 voxels costs, from its file to a fitted mesh: wall and CPU time, and the most memory.

    python3 benches/label_volumes.py [PROGRAM] [BUILD]   # enters benches/results/label_volumes.csv

PROGRAM is `mesocrete` by default, BUILD the word for it in the table, `release` by default. The volume has the grains of a
75 mm cube (0.45, 5 to 20 mm), so that every figure has a reference. `--quick` takes 64^3 voxels of a 40 mm cube and enters
nothing.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from images import measure
from origin import RESULTS, origin

TABLE = RESULTS / "label_volumes.csv"
HEADER = "work,grains,size_mm,fraction,exact_fraction,triangles_or_cells,wall_s,cpu_s,peak_mb,build,machine,date,commit"
ELEMENT_MM = 2.5


def main():
    quick = "--quick" in sys.argv
    words = [word for word in sys.argv[1:] if word != "--quick"]
    program, build = [*words, *("mesocrete", "release")[len(words) :]]
    count, side_mm = (64, 40.0) if quick else (256, 75.0)
    voxel = str(side_mm / count)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        spec, packed, ids = folder / "spec.toml", folder / "packed.json", folder / "ids.npy"
        model, mesh, summary = folder / "model.json", folder / "mesh.vtu", folder / "mesh.json"
        specimen = f'{{ kind = "cube", side_mm = {side_mm} }}'
        spec.write_text(f"fraction = 0.45\nspecimen = {specimen}\ngrading = {{ d_min_mm = 5, d_max_mm = 20 }}\n")
        subprocess.run([program, "pack", spec, "-qo", packed], check=True)
        subprocess.run([program, "image", packed, "--what", "grain", "--voxel-size-mm", voxel, "-qo", ids], check=True)
        flags = ["--mortar=-1", "--voxel-size-mm", voxel, "-qo", str(model)]
        imported = measure([program, "import", str(ids), *flags])
        flags = ["--method", "lattice", "--itz", "none", "--element-size-mm", str(ELEMENT_MM), "--volumes", "exact", "-qo", str(mesh)]
        meshed = measure([program, "mesh", str(model), *flags, "--summary-json", str(summary)])
        subprocess.run([program, "check", model], check=True, stdout=subprocess.DEVNULL)
        lines = rows(json.loads(model.read_text()), json.loads(summary.read_text()), float(voxel), imported, meshed, build)
    print("\n".join(lines))
    if quick:
        return
    known = TABLE.read_text().splitlines()[1:] if TABLE.exists() else []
    TABLE.write_text("\n".join([HEADER, *known, *lines]) + "\n")


def rows(model, summary, voxel, imported, meshed, build):
    """One row for the import and one for the mesh; fractions are of surfaces and labels, then of cells and surfaces."""
    report, grains = model["report"], len(model["aggregates"])
    triangles = sum(len(aggregate["faces"]) for aggregate in model["aggregates"])
    labels, cells = report["labels"]["fraction"], summary["elements"]
    volumes = summary["quality"]["volumes_mm3"]
    aggregate = volumes["aggregate"] / sum(volumes.values())
    of_import = f"import,{grains},{voxel},{report['fraction']:.6f},{labels:.6f},{triangles}"
    of_mesh = f"mesh,{grains},{ELEMENT_MM},{aggregate:.6f},{report['fraction']:.6f},{cells}"
    costs = ((of_import, imported), (of_mesh, meshed))
    return [f"{row},{wall:.1f},{cpu:.1f},{peak:.0f},{build},{origin()}" for row, (wall, cpu, peak) in costs]


if __name__ == "__main__":
    main()
