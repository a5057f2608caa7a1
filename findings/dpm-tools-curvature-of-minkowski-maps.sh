#!/usr/bin/env bash
# dpm-tools 1.0.2: the mean curvature of minkowski_map() is that of minkowski_functionals() over (2 pi)^2.
# The map divides by 2 pi where the functional multiplies by it; volume, area and Euler number of the map are right.
# Seen: a ball of radius 10 voxels has an integral of 131.9 by minkowski_functionals() and of 3.342 in the window of the map
# around it; right is 4 pi r = 125.7. A bar of 8 x 12 x 16 voxels has 75.4 and 1.91. In 2D the perimeters agree.
# Fix: multiply the third map by 4 pi^2.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps dpm-tools==1.0.2 pyfftw==0.15.1 dpm-srg==0.0.5 dpm-srm==0.1.9 netcdf4==1.7.5.1.post1 cftime==1.6.6.1 certifi==2026.10.19.post1 h5py==3.16.0 wget==3.2 exifread==3.5.1 scikit-fmm==2025.6.23 requests==2.34.2 urllib3==2.8.0 idna==3.20 charset-normalizer==3.5.3 porespy==3.2.0 scikit-image==0.26.0 scipy==1.17.1 numba==0.68.1 llvmlite==0.50.0 numpy==2.4.6 edt==3.0.0 connected-components-3d==4.1.1 dask==2026.8.0 cloudpickle==3.1.3 fsspec==2026.9.0 toolz==1.2.0 partd==1.4.2 locket==1.0.0 pyyaml==6.0.4 importlib-metadata==10.2.0 zipp==4.1.2 deprecated==1.3.1 wrapt==2.5.2 imageio==2.38.1 pillow==13.0.0 lazy-loader==0.6 lazy-importer==0.1.0 tifffile==2026.3.3 pandas==3.1.1 python-dateutil==4.0.0 six==1.17.0 networkx==3.6.1 packaging==26.4 matplotlib==3.11.2 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 pyparsing==3.3.3 tqdm==4.70.1 psutil==7.2.2 pooch==1.9.0 platformdirs==4.14.9 pyvista==0.49.1 pyvista-validation==0.2.2 scooby==0.12.1 typing-extensions==4.16.0 vtk==9.7.2 loguru==0.7.3 rich==15.0.0 jinja2==3.1.6 markupsafe==3.0.4
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from dpm_tools.metrics import minkowski_functionals, minkowski_map

size, middle = 65, 32
away = np.indices((size,) * 3) - middle
bodies = {"ball": (away**2).sum(0) <= 10**2, "bar": np.zeros((size,) * 3, bool)}
bodies["bar"][28:36, 26:38, 24:40] = True
ratio = {}
for name, body in bodies.items():
    whole = np.array(minkowski_functionals(body.astype(np.uint8)))
    window = np.array([part[middle, middle, middle] for part in minkowski_map(body.astype(np.uint8), [31, 31, 31])])
    ratio[name] = whole / window
    print("dpm-tools", importlib.metadata.version("dpm-tools"), name, whole.round(2), "in its map:", window.round(3))
    assert np.allclose(ratio[name], [1, 1, 4 * np.pi**2, 1])
assert abs(minkowski_functionals(bodies["ball"].astype(np.uint8))[2] / (4 * np.pi * 10) - 1) < 0.06
square = np.zeros((size, size), np.uint8)
square[22:42, 24:40] = 1
assert np.allclose(minkowski_functionals(square), [part[middle, middle] for part in minkowski_map(square, [31, 31])])
PYTHON
