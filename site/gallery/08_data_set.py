"""A data set for machine learning

A study makes as many labelled volumes as needed, each in a folder of its own. A killed run goes on where it was.
"""
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import mesocrete as mc


def volume(packing: mc.Packing, folder: Path) -> dict[str, float]:
    """Write the labels of a packing; return what a network is to predict."""
    label = packing.voxelize(1.0)
    np.save(folder / "label.npy", label)
    return {"aggregate": float(np.isin(label, (1, 2)).mean())}  # the ITZ is a part of the aggregate


spec = {"specimen": mc.Specimen.cube(40), "grading": mc.Grading.fuller(5, 12)}
study = mc.study(spec, {"fraction": [0.2, 0.3, 0.4], "seed": range(3)}, then=volume, out="data")
table = study.table()
print(table["fraction"], table["aggregate"].round(4))

figure, axes = plt.subplots(3, 3, figsize=(6, 6))
for axis, folder in zip(axes.flat, study.folders, strict=True):
    axis.imshow(np.load(folder / "label.npy")[20], cmap="bone", origin="lower")
    axis.set_axis_off()
figure.savefig("picture.png", dpi=120)
