"""A CT volume, crushed

A segmented scan is a specimen like any other: its grains get smooth surfaces and keep their labels, every pair is proved
apart, and the test crushes them. Here the scan is one of our own packings, so the true grains are known; a file of yours
(`.tif`, `.npy`, `.vti`) takes the array's place. [Label volumes](../packing.md#label-volumes) has the options.
"""
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from scipy import ndimage

import mesocrete as mc

spec = {"specimen": mc.Specimen.cube(30), "grading": mc.Grading.fuller(5, 10), "fraction": 0.3, "placement": {"min_gap_mm": 1.0}, "itz": {"thickness_mm": [0, 0]}}
truth = mc.pack(spec, seed=1)
grey = mc.scan(truth, shape=120, seed=1)

# A threshold separates stone from mortar, and every connected part is a grain.
labels, count = ndimage.label(ndimage.median_filter(grey, 3) > 140)
packing = mc.from_labels(labels, voxel_size=0.25)
print(f"{count} parts, {len(packing)} grains of {len(truth)}; fraction {packing.fraction:.4f} for {truth.fraction:.4f}")

# The model is meshed and crushed as a packing is.
response = packing.mesh(for_test=True, element_size=1.5).solve(friction=0.1, frames=2)
print({key: response.result[key] for key in ("elements", "peak_mpa", "peak_strain")})
print(f"{response.result['seconds']['total']:.0f} s")

grid = response.to_pyvista()
look: dict[str, Any] = {"cmap": "Reds", "lighting": False, "show_scalar_bar": False, "cpos": "xz", "clim": (0.0, 0.03)}
body = grid.slice("y").plot(scalars="crack_opening_mm", **look, off_screen=True, return_img=True, screenshot="body.png")
figure, axes = plt.subplots(1, 3, figsize=(12, 3.8))
middle = grey.shape[1] // 2
axes[0].imshow(grey[:, middle], origin="lower", cmap="gray")
axes[0].contour(np.asarray(packing.voxelize(shape=120, what="grain"))[:, middle] >= 0, levels=[0.5], colors="tab:orange")
axes[0].set(title="scan, and surfaces in orange", xticks=[], yticks=[])
axes[1].imshow(body[1] if isinstance(body, tuple) else body)
axes[1].set_title("cracks at the end")
axes[1].axis("off")
response.plot(ax=axes[2])
figure.tight_layout()
figure.savefig("picture.png", dpi=120)
