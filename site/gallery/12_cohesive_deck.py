"""A deck with a cohesive ITZ

The deck holds everything that Abaqus needs for a compression test with a cohesive ITZ. [Into Abaqus/CAE](../abaqus.md) goes on
from here.
"""
from pathlib import Path

import mesocrete as mc

spec = {"specimen": mc.Specimen.cube(30), "grading": mc.Grading.fuller(8, 14), "placement": {"min_gap_mm": 1.0}}
packing = mc.pack(spec, fraction=0.2, seed=1)
mesh = packing.mesh(method="lattice", element_size=3.0, itz="cohesive")
mesh.write("test.inp", analysis="compression")
text = Path("test.inp").read_text()
print([line for line in text.splitlines() if line.startswith("*ELEMENT")])
print(len(mesh), "elements,", len(mesh.cohesive), "of them cohesive")

mesh.plot(cut="y", screenshot="picture.png")
