"""Pairs of noisy tomography-like slices and exact labels, to train a segmentation network."""

import numpy as np

import mesocrete as mc

spec = {"specimen": {"kind": "cylinder", "diameter_mm": 50, "height_mm": 50}, "fraction": 0.35}
packing = mc.pack(spec, seed=1)
label = packing.voxelize(0.5)
grey = mc.scan(packing, 0.5)  # partial volume at the edges, blur, noise and rings, as a scanner has them
np.savez_compressed("training.npz", image=grey, label=label, grain=packing.voxelize(0.5, "grain"))
print(f"{len(grey)} slices of {grey.shape[1:]} pixels; aggregate {np.mean(label[label < 255] > 0):.3f} of the specimen")
