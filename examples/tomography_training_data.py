"""Pairs of noisy tomography-like slices and exact labels, to train a segmentation network."""

import numpy as np

import mesocrete as mc

random = np.random.default_rng(0)
spec = {"specimen": {"kind": "cylinder", "diameter_mm": 50, "height_mm": 50}, "fraction": 0.35}
packing = mc.pack(spec, seed=1)
share, label = packing.voxelize(0.5, "share"), packing.voxelize(0.5)
grey = np.where(label == 255, 0.0, 0.45 + 0.25 * share)  # partial volume at the edges, as a scanner has it
grey = np.clip(grey + random.normal(0.0, 0.05, grey.shape), 0.0, 1.0)
np.savez_compressed("training.npz", image=(255 * grey).astype(np.uint8), label=label, grain=packing.voxelize(0.5, "grain"))
print(f"{len(grey)} slices of {grey.shape[1:]} pixels; aggregate {np.mean(label[label < 255] > 0):.3f} of the specimen")
