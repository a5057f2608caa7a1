"""A data set for machine learning

One call makes as many labelled volumes as needed, each with its metadata. A killed call goes on where it was.
"""
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import mesocrete as mc

spec = {"specimen": mc.Specimen.cube(40), "grading": mc.Grading.fuller(5, 12)}
ranges = {"fraction": (0.2, 0.4), "grading.d_max_mm": [10, 12]}  # a Latin hypercube over the spec
data = mc.dataset(9, ranges, spec=spec, shape=64, what=["phase", "scan"], sink="data.zarr")
print(data.table()["fraction"].round(3))


# PyTorch needs a length and items. `torch.utils.data.DataLoader(Volumes(data), batch_size=4)` takes this class as it is:
class Volumes:
    """Scans, and the labels that a network is to predict."""

    def __init__(self, data: mc.Dataset) -> None:
        self.data = data

    def __len__(self) -> int:
        return len(self.data)

    def __getitem__(self, i: int) -> tuple[Any, Any]:
        volume = self.data[i]
        return volume["scan"][None].astype(np.float32) / 255, volume["phase"].astype(np.int64)


scan, label = Volumes(data)[0]
figure, axes = plt.subplots(2, 5, figsize=(8, 3.4))
for axis, (image, title) in zip(axes.flat, [pair for i in range(5) for pair in ((i, "scan"), (i, "phase"))], strict=True):
    axis.imshow(data[image][title][32], cmap="bone", origin="lower")
    axis.set(title=f"{title} {image}", xticks=[], yticks=[])
figure.savefig("picture.png", dpi=120)
