#!/usr/bin/env bash
# Netgen 6.2.2608: Export(name, "Gmsh2 Format") keeps Netgen's order of nodes, in which a tetrahedron is inside out for gmsh.
# Seen: all tetrahedra have a negative volume in gmsh, and the names of the materials are gone: 100001, 100002 are left.
# The export "Abaqus Format" of the same mesh turns them and has the names.
# Mends it: gmsh.model.mesh.reverse() of the volumes after the file is open, or the way over "Abaqus Format".
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile netgen-mesher==6.2.2608 gmsh==4.15.2 meshio==5.3.5 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import gmsh
import meshio
import numpy as np
from netgen.csg import CSGeometry, OrthoBrick, Pnt, Sphere

geometry = CSGeometry()
box, stone = OrthoBrick(Pnt(0, 0, 0), Pnt(2, 2, 2)), Sphere(Pnt(1, 1, 1), 0.6)
geometry.Add((box - stone).mat("MORTAR"))
geometry.Add(stone.mat("STONE"))
mesh = geometry.GenerateMesh(maxh=0.8)
mesh.Export("own.msh", "Gmsh2 Format")
mesh.Export("own.inp", "Abaqus Format")
deck = meshio.read("own.inp")
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.open("own.msh")


def volumes():
    tags = gmsh.model.mesh.getElementsByType(4)[0]
    return np.array(gmsh.model.mesh.getElementQualities(tags, "volume"))


read = volumes()
groups = [(tag, gmsh.model.getPhysicalName(3, tag)) for _, tag in gmsh.model.getPhysicalGroups(3)]
gmsh.model.mesh.reverse(gmsh.model.getEntities(3))
turned = volumes()
cells = np.vstack([block.data for block in deck.cells if block.type == "tetra"])
abaqus = np.linalg.det(deck.points[cells[:, 1:]] - deck.points[cells[:, :1]]) / 6
names = sorted(deck.cell_sets)
print("netgen", importlib.metadata.version("netgen-mesher"), len(read), "tetrahedra: volume", read.sum(), groups)
print("once turned", turned.sum(), "by Abaqus Format", abaqus.sum(), names)
assert read.max() < 0 and abs(read.sum() + 8) < 1e-6 and groups == [(100001, ""), (100002, "")]
assert turned.min() > 0 and abaqus.min() > 0 and abs(abaqus.sum() - 8) < 1e-6 and {"MORTAR", "STONE"} <= set(names)
gmsh.finalize()
PYTHON
