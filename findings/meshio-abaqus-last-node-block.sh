#!/usr/bin/env bash
# meshio 5.3.5: of several *NODE blocks of an Abaqus deck only the last is kept.
# Abaqus adds the nodes of every block. Seen: a deck of 4 + 1 nodes has 1 point and no message; its cell names 4 nodes.
# Mends it: one *NODE block with all nodes.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile meshio==5.3.5 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import meshio
import numpy as np

deck = """*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
4, 0., 0., 1.
*ELEMENT, TYPE=C3D4
1, 1, 2, 3, 4
*NODE, NSET=REF
5, 9., 9., 9.
"""
one = deck.replace("*NODE, NSET=REF\n5, 9., 9., 9.\n", "").replace("4, 0., 0., 1.\n", "4, 0., 0., 1.\n5, 9., 9., 9.\n")
for name, text in (("two.inp", deck), ("one.inp", one)):
    with open(name, "w") as file:
        file.write(text)
two, one = meshio.read("two.inp"), meshio.read("one.inp")
print("meshio", meshio.__version__, "two blocks:", len(two.points), "points; one block:", len(one.points))
assert np.array_equal(two.points, [[9.0, 9.0, 9.0]]) and len(two.cells[0].data) == 1
assert len(one.points) == 5
PYTHON
