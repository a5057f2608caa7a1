"""Homogenise a periodic cell

The effective conductivity of a periodic volume element, by the FFT scheme of Moulinec and Suquet in twenty lines of numpy.
`voxelize` returns the labels as an array [z, y, x].
"""
import matplotlib.pyplot as plt
import numpy as np

import mesocrete as mc

spec = {"specimen": mc.Specimen.cube(40, periodic=True), "grading": mc.Grading.fuller(5, 12)}
packing = mc.pack(spec, fraction=0.4, seed=1)
n = 40
aggregate = np.isin(packing.voxelize(40 / n), (1, 2))  # with its ITZ
conductivity = np.where(aggregate, 3.0, 1.5)  # aggregate and mortar, W/(m K)

frequency = np.stack(np.meshgrid(*3 * [np.fft.fftfreq(n)], indexing="ij"))
frequency[:, n // 2, :, :] = frequency[:, :, n // 2, :] = frequency[:, :, :, n // 2] = 0.0
square = (frequency**2).sum(axis=0)
square[square == 0.0] = 1.0
reference = (conductivity.min() + conductivity.max()) / 2
gradient = np.zeros((3, n, n, n))
gradient[2] = 1.0  # along x
for _ in range(60):
    polarisation = np.fft.fftn((conductivity - reference) * gradient, axes=(1, 2, 3))
    update = -frequency * (frequency * polarisation).sum(axis=0) / square / reference
    update[:, 0, 0, 0] = 0.0
    gradient = np.fft.ifftn(update, axes=(1, 2, 3)).real
    gradient[2] += 1.0
effective = (conductivity * gradient[2]).mean()

# Hashin and Shtrikman's bounds enclose it.
f = aggregate.mean()
low = 1.5 + f / (1 / (3.0 - 1.5) + (1 - f) / (3 * 1.5))
high = 3.0 + (1 - f) / (1 / (1.5 - 3.0) + f / (3 * 3.0))
print(f"{low:.4f} <= {effective:.4f} <= {high:.4f} W/(m K)")
assert low < effective < high

figure, axes = plt.subplots(1, 2, figsize=(8, 4))
axes[0].imshow(aggregate[n // 2], origin="lower", cmap="bone")
axes[1].imshow((conductivity * gradient[2])[n // 2], origin="lower", cmap="magma")
axes[0].set_title("phases")
axes[1].set_title("flux along x")
figure.savefig("picture.png", dpi=120)
