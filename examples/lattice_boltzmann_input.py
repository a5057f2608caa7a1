"""Solid and fluid cells of a lattice Boltzmann run: flow through the space between the aggregates."""

import numpy as np
from scipy import ndimage

import mesocrete as mc

packing = mc.pack({"specimen": {"kind": "box", "size_mm": [40, 40, 60]}, "fraction": 0.35}, seed=1)
solid = np.isin(packing.voxelize(0.5), (1, 2, 255))  # ITZ, aggregate, outside; [z, y, x]
np.save("solid.npy", solid)
(solid.astype(np.uint8)).tofile("geometry.dat")  # x fastest, as Palabos and others read it
channels, count = ndimage.label(~solid)
through = np.intersect1d(channels[0], channels[-1])
open_share = np.isin(channels, through[through > 0]).mean()
print(f"{solid.shape} cells, {(~solid).mean():.3f} fluid, {open_share:.3f} connects bottom and top")
