#!/usr/bin/env bash
# lsdyna-mesh-reader 0.2.1: to_grid() takes the first *NODE block alone; an element with nodes of a second raises IndexError.
# LS-DYNA adds the nodes of every block. Mends it: one *NODE block.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile lsdyna-mesh-reader==0.2.1 pyvista==0.49.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import lsdyna_mesh_reader

node = lambda number, xyz: f"{number:8d}" + "".join(f"{x:16.8f}" for x in xyz) + f"{0:8d}{0:8d}\n"
points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
lines = [node(i, p) for i, p in enumerate(points, 1)]
element = "*ELEMENT_SOLID\n" + "".join(f"{n:8d}" for n in [1, 1, *range(1, 9)]) + "\n*END\n"
for name, text in (("one.k", "*KEYWORD\n*NODE\n" + "".join(lines)), ("two.k", "*KEYWORD\n*NODE\n" + "".join(lines[:4]) + "*NODE\n" + "".join(lines[4:]))):
    with open(name, "w") as file:
        file.write(text + element)
grid = lsdyna_mesh_reader.Deck("one.k").to_grid()
deck = lsdyna_mesh_reader.Deck("two.k")
sizes = [len(section) for section in deck.node_sections]
try:
    deck.to_grid()
    said = "nothing"
except IndexError as error:
    said = f"IndexError: {error}"
print("one block:", grid.n_points, "points", grid.n_cells, "cells; two blocks of", sizes, "nodes:", said)
assert (grid.n_points, grid.n_cells, sizes) == (8, 1, [4, 4]) and said.startswith("IndexError")
PYTHON
