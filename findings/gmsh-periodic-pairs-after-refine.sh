#!/usr/bin/env bash
# gmsh 4.15.2: after refine() of a mesh that was read from a file, the pairs of periodic surfaces are those from before.
# With the geometry at hand they are right.
# Seen: as many pairs as on the coarse mesh; after write() and open() all nodes of the refined surface have a partner.
# Mends it: write the refined mesh and open it again before getPeriodicNodes().
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile gmsh==4.15.2 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import gmsh
import numpy as np

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
gmsh.model.occ.synchronize()
find = lambda x: [t for _, t in gmsh.model.getEntitiesInBoundingBox(x - 1e-3, -1, -1, x + 1e-3, 2, 2, 2)][0]
low, high = find(0.0), find(1.0)
gmsh.model.mesh.setPeriodic(2, [high], [low], [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
gmsh.option.setNumber("Mesh.MeshSizeMin", 0.3)
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.3)
gmsh.model.mesh.generate(3)


def count():
    pairs = len(gmsh.model.mesh.getPeriodicNodes(2, high)[1])
    nodes = len(np.unique(gmsh.model.mesh.getElementsByType(2, high)[1]))
    return pairs, nodes


gmsh.model.addPhysicalGroup(3, [1])
gmsh.model.addPhysicalGroup(2, [low, high])
gmsh.write("coarse.msh")
gmsh.model.mesh.refine()
with_geometry = count()
gmsh.open("coarse.msh")
coarse = count()
gmsh.model.mesh.refine()
fine = count()
gmsh.write("fine.msh")
gmsh.open("fine.msh")
again = count()
print("gmsh", gmsh.__version__, "pairs and nodes of a face: with geometry", with_geometry, "read", coarse, "refined", fine, "opened again", again)
assert with_geometry[0] == with_geometry[1]
assert coarse[0] == coarse[1] and fine[0] == coarse[0] < fine[1] and again[0] == again[1] == fine[1]
gmsh.finalize()
PYTHON
