#!/usr/bin/env bash
# microct-porous-media 1.0.1: the critical diameter of analyze_pore_properties() is that of the smallest pore voxels.
# It should be the largest diameter at which the pores still connect two opposite faces. Sizes are tried from the smallest one upward,
# and the first that connects them, which the smallest does wherever anything does, ends the search.
# Seen: a straight channel 300 um wide through a block, 15 um a voxel, has a critical diameter of 30 um, two voxels.
# The density of surface is per 1000 volumes, since um3 are divided by 1e6, not 1e9, to have mm3, and each voxel at the rim
# counts with six faces: 0.014 1/mm for the channel, 2.62 is right. compute_euler_number() has 2 for the channel, 0 for three
# separate boxes; right are 1 and 3.
# Fix: the distance transform and a search from the largest size downward; skimage.measure.euler_number().
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps microct-porous-media==1.0.1 openpnm==3.6.4 skan==0.13.1 pyamg==5.4.1 pypardiso==0.4.7 transforms3d==0.4.2 docrep==0.3.2 mkl==2026.2.0 porespy==3.2.0 scikit-image==0.26.0 scipy==1.17.1 numba==0.68.1 llvmlite==0.50.0 numpy==2.4.6 edt==3.0.0 connected-components-3d==4.1.1 dask==2026.8.0 cloudpickle==3.1.3 fsspec==2026.9.0 toolz==1.2.0 partd==1.4.2 locket==1.0.0 pyyaml==6.0.4 importlib-metadata==10.2.0 zipp==4.1.2 deprecated==1.3.1 wrapt==2.5.2 imageio==2.38.1 pillow==13.0.0 lazy-loader==0.6 lazy-importer==0.1.0 tifffile==2026.3.3 pandas==3.1.1 python-dateutil==4.0.0 six==1.17.0 networkx==3.6.1 packaging==26.4 matplotlib==3.11.2 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 pyparsing==3.3.3 tqdm==4.70.1 psutil==7.2.2 pooch==1.9.0 platformdirs==4.14.9 pyvista==0.49.1 pyvista-validation==0.2.2 scooby==0.12.1 typing-extensions==4.16.0 vtk==9.7.2 loguru==0.7.3 rich==15.0.0 jinja2==3.1.6 markupsafe==3.0.4
cd "$folder"
"$folder/venv/bin/python" -W ignore - <<'PYTHON'
import contextlib
import importlib.metadata
import io

import numpy as np
from microctpm import pore_metrics
from scipy import ndimage
from skimage import measure

size, voxel, radius = 40, 0.015, 10
y, z = np.indices((size, size)) - (size - 1) / 2
channel = np.repeat((y**2 + z**2 <= radius**2)[None], size, axis=0)
boxes = np.zeros((size,) * 3, bool)
for start in (4, 14, 24):
    boxes[start : start + 6, 10:20, 10:20] = True


def quiet(function, image):
    with contextlib.redirect_stdout(io.StringIO()):
        return function(image)


distance = ndimage.distance_transform_edt(channel)


def connects(diameter):
    labels = measure.label(distance >= diameter / 2)
    return np.intersect1d(labels[0][labels[0] > 0], labels[-1][labels[-1] > 0]).size > 0


sizes = np.unique(distance[channel]) * 2
largest = 1000 * voxel * max(s for s in sizes if connects(s))
result = quiet(pore_metrics.analyze_pore_properties, channel)
density, percolates, critical = float(result[5]), result[7], float(result[8])
right = 2 * np.pi * radius / (size**2 * voxel)
print("microct-porous-media", importlib.metadata.version("microct-porous-media"), "critical diameter:", critical, "um")
print("  largest that connects:", round(largest), "um; surface:", density, "1/mm, right:", round(right, 2))
assert percolates and critical == 1000 * voxel * sizes.min() == 30
assert 280 < largest < 320 and density < right / 150
for name, image, pieces in (("channel", channel, 1), ("boxes", boxes, 3)):
    seen = quiet(pore_metrics.compute_euler_number, image) * (size * voxel) ** 3
    euler = measure.euler_number(image, connectivity=3)
    print(f"  {name}: Euler number {seen:.3f}, by scikit-image {euler}")
    assert euler == pieces and abs(seen - {"channel": 2, "boxes": 0}[name]) < 1e-9
PYTHON
