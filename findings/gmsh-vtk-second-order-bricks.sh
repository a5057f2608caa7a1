#!/usr/bin/env bash
# gmsh 4.15.2: 20-node bricks and 15-node prisms of a .vtk are taken in gmsh's order of nodes, which is another one.
# Its own writer has the order of VTK right, so that gmsh does not read back what it wrote.
# Seen: a unit brick read from .vtk has a volume of -0.3, without a message; 10-node tetrahedra are right.
# Mends it: .msh or .unv.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile gmsh==4.15.2
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
brick = corners + [tuple((a + b) / 2 for a, b in zip(corners[i], corners[j])) for i, j in edges]
with open("brick.vtk", "w") as file:
    file.write("# vtk DataFile Version 2.0\nbrick\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 20 double\n")
    file.write("".join("%g %g %g\n" % p for p in brick))
    file.write("\nCELLS 1 21\n20 " + " ".join(map(str, range(20))) + "\n\nCELL_TYPES 1\n25\n")


def volume(name):
    gmsh.open(name)
    kinds, tags, _ = gmsh.model.mesh.getElements(3)
    volumes = [v for t in tags for v in gmsh.model.mesh.getElementQualities(t, "volume")]
    return list(map(int, kinds)), round(float(sum(volumes)), 6)


read = volume("brick.vtk")
gmsh.clear()
gmsh.model.occ.addBox(0, 0, 0, 1, 2, 3)
gmsh.model.occ.synchronize()
gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
gmsh.option.setNumber("Mesh.ElementOrder", 2)
for _, curve in gmsh.model.getEntities(1):
    gmsh.model.mesh.setTransfiniteCurve(curve, 2)
for _, surface in gmsh.model.getEntities(2):
    gmsh.model.mesh.setTransfiniteSurface(surface)
    gmsh.model.mesh.setRecombine(2, surface)
gmsh.model.mesh.setTransfiniteVolume(1)
gmsh.model.mesh.generate(3)
for name in ("box.vtk", "box.msh", "box.unv"):
    gmsh.write(name)
again = {name: volume(name) for name in ("box.vtk", "box.msh", "box.unv")}
print("gmsh", gmsh.__version__, "kind of element and volume of a unit brick:", read, "of its own box of 6:", again)
assert read == ([17], -0.3)
assert again["box.msh"] == again["box.unv"] == ([17], 6) and again["box.vtk"] == ([17], -1.8)
gmsh.finalize()
PYTHON
