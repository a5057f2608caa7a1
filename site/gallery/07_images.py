"""Images as a scanner makes them

A label image, and a grey one with blur and noise, as tomography would give it: the truth for testing a segmentation.
"""
import matplotlib.pyplot as plt
import numpy as np
from scipy import ndimage

import mesocrete as mc

packing = mc.pack({"specimen": mc.Specimen.cube(50)}, fraction=0.4, seed=9)
n = 100
mesh = packing.mesh(method="voxel", element_size=50 / n, itz="none")
label = mesh.phase.reshape(n, n, n)  # [z, y, x]; 0 mortar, 2 aggregate
grain = mesh.aggregate.reshape(n, n, n)

random = np.random.default_rng(1)
grey = ndimage.gaussian_filter(np.where(label == 2, 150.0, 100.0), 1.0) + random.normal(0, 8, label.shape)
np.save("label.npy", label)

# How well a threshold finds the aggregates again:
found = ndimage.median_filter(grey, 3) > 125
print(f"right voxels: {(found == (label == 2)).mean():.4f}")

figure, axes = plt.subplots(1, 3, figsize=(10, 3.6))
for axis, image, title in zip(axes, (label, grain, grey), ("phases", "grains", "scan"), strict=True):
    axis.imshow(image[n // 2], origin="lower", cmap="prism" if title == "grains" else "gray", interpolation="nearest")
    axis.set(title=title, xticks=[], yticks=[])
figure.savefig("picture.png", dpi=120)
