"""Your own grains

Scanned grains come as STL or JSON files, or as arrays: the hull of each is drawn at random and scaled to its class.
"""
import numpy as np

import mesocrete as mc

# Stand-ins for a scan: three slender bodies.
random = np.random.default_rng(5)
grains = [(random.normal(size=(24, 3)) * [1.0, 0.7, 0.5]).tolist() for _ in range(3)]
spec = {"specimen": mc.Specimen.cube(60), "shape": {"kind": "library", "grains": grains}}
packing = mc.pack(spec, fraction=0.3, seed=4)
print(len(packing), "grains of three shapes")

# Files are named instead: `{"kind": "library", "library": ["scan-1.stl", "more-grains.json"]}`.
packing.plot(screenshot="picture.png")
