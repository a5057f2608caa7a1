"""One packing, several meshes

The same packing meshed ever finer: what an element size gets wrong. A fitted lattice
needs elements of at most 0.4 of the smallest aggregate, here 2.4 mm.
"""
import matplotlib.pyplot as plt

import mesocrete as mc

packing = mc.pack({"specimen": mc.Specimen.cube(40), "grading": mc.Grading.fuller(6, 14)}, fraction=0.3, seed=1)
rows = []
for size in (3.0, 2.0, 1.5):
    voxel = packing.mesh(method="voxel", element_size=size, itz="none")
    lattice = packing.mesh(method="lattice", element_size=size, itz="none")
    shares = [mesh.volumes()["aggregate"] / 40**3 for mesh in (voxel, lattice)]
    rows.append((size, *shares))
    print(f"{size:g} mm: voxels {shares[0]:.4f}, fitted lattice {shares[1]:.4f}; exact {packing.fraction:.4f}")

figure, axes = plt.subplots(figsize=(6, 4))
sizes, voxels, lattices = zip(*rows, strict=True)
axes.plot(sizes, voxels, "s-", label="voxels")
axes.plot(sizes, lattices, "^-", label="fitted lattice")
axes.axhline(packing.fraction, color="black", label="exact")
axes.set(xlabel="element size, mm", ylabel="aggregate share")
axes.legend()
figure.savefig("picture.png", dpi=120)
