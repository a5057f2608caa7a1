#!/usr/bin/env bash
# meshio 5.3.5: a .med file that it writes has the nodes of cells in meshio's order; MED orders them the other way round.
# gmsh and MEDCoupling, which keep to MED, see cells that are inside out. Seen: tetrahedra, bricks, prisms and pyramids
# have negative volumes in both, and a .med of gmsh has them in meshio. meshio alone reads its own file as it was.
# Mends it: MEDCoupling's orientCorrectly3DCells(), or gmsh for the way from .msh to .med.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile meshio==5.3.5 h5py==3.16.0 gmsh==4.15.2 medcoupling==9.15.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import gmsh
import medcoupling
import meshio
import numpy as np

prism = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
brick = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
pyramid = np.vstack([brick[:4], [0.5, 0.5, 1.0]])
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
for kind, points in (("tetra", prism[:4]), ("hexahedron", brick), ("wedge", prism), ("pyramid", pyramid)):
    cells = [(kind, [list(range(len(points)))])]
    volumes = []
    for name in ("own.msh", "own.med"):
        meshio.write(name, meshio.Mesh(points, cells), **({"file_format": "gmsh"} if name == "own.msh" else {}))
        gmsh.open(name)
        tag = gmsh.model.mesh.getElements(3)[1][0]
        volumes.append(round(float(gmsh.model.mesh.getElementQualities(tag, "volume")[0]), 6))
    grid = medcoupling.MEDFileMesh.New("own.med")[0]
    signed = lambda: round(grid.getMeasureField(False).getArray().toNumPyArray()[0], 6)
    before = signed()
    grid.orientCorrectly3DCells()
    print("meshio", meshio.__version__, kind, "gmsh: .msh, .med", volumes, "MEDCoupling:", before, "once turned", signed())
    assert volumes[0] > 0 and volumes[1] == -volumes[0] and abs(before - volumes[1]) < 1e-5 and signed() == -before
gmsh.clear()
gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
gmsh.model.occ.synchronize()
gmsh.model.addPhysicalGroup(3, [1], name="STONE")
gmsh.model.mesh.generate(3)
gmsh.write("gmsh.med")
mesh = meshio.read("gmsh.med")
cells = np.vstack([block.data for block in mesh.cells if block.type == "tetra"])
volume = np.linalg.det(mesh.points[cells[:, 1:]] - mesh.points[cells[:, :1]]).sum() / 6
print("gmsh", gmsh.__version__, "cube of 1, as meshio reads its .med:", round(volume, 6))
assert abs(volume + 1) < 1e-9
gmsh.finalize()
PYTHON
