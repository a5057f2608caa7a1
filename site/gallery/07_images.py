"""Images as a scanner makes them

A label image, and a grey one with blur and noise, as tomography would give it: the truth for testing a segmentation.
"""
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from scipy import ndimage

import mesocrete as mc

packing = mc.pack({"specimen": mc.Specimen.cube(50)}, fraction=0.4, seed=9)
label = packing.voxelize(0.5)  # [z, y, x]; 0 mortar, 1 ITZ, 2 aggregate
grain = packing.voxelize(0.5, what="grain")  # ids; -1 in the mortar
np.save("label.npy", label)

# Partial volumes from exact shares, blur, noise and rings; each has its keyword.
grey = mc.scan(packing, 0.5, seed=1, blur=1.0, noise=0.03)

# How well a threshold between mortar (0.45) and aggregate (0.65) finds the aggregates again:
found = ndimage.median_filter(grey, 3) > 255 * 0.55
print(f"right voxels: {(found == (grain >= 0)).mean():.4f}")

figure, axes = plt.subplots(1, 3, figsize=(10, 3.6))
ids = np.ma.masked_less(grain, 0)
images: tuple[Any, ...] = (label, ids, grey)
for axis, image, title in zip(axes, images, ("phases", "grains", "scan"), strict=True):
    axis.imshow(image[len(image) // 2], origin="lower", cmap="tab20" if title == "grains" else "gray", interpolation="nearest")
    axis.set(title=title, xticks=[], yticks=[])
figure.savefig("picture.png", dpi=120)
