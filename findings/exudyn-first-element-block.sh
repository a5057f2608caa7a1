#!/usr/bin/env bash
# exudyn 1.13.6: ImportFromAbaqusInputFile() takes the first *Element block of a part alone, without a message.
# Abaqus adds the elements of every block, and a deck with phases has one for each.
# Seen: of a mortar and a stone element the stone is missing; all nodes are there, so that nodes without mass remain.
# Mends it: one *Element block with all elements.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile exudyn==1.13.6 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

from exudyn.FEM import FEMinterface

start = """*Heading
*Part, name=Part-1
*Node
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
4, 0., 0., 1.
5, 1., 1., 1.
*Element, type=C3D4
1, 1, 2, 3, 4
"""
seen = {}
for name, between in (("two blocks", "*Element, type=C3D4, elset=STONE\n"), ("one block", "")):
    with open("deck.inp", "w") as file:
        file.write(start + between + "2, 2, 5, 3, 4\n*End Part\n")
    model = FEMinterface()
    model.ImportFromAbaqusInputFile("deck.inp")
    seen[name] = model.NumberOfNodes(), [block["Tet4"].tolist() for block in model.elements]
print("exudyn", importlib.metadata.version("exudyn"), "nodes and tetrahedra:", seen)
assert seen["two blocks"] == (5, [[[0, 1, 2, 3]]]) and seen["one block"] == (5, [[[0, 1, 2, 3], [1, 4, 2, 3]]])
PYTHON
