#!/usr/bin/env bash
# dpm-tools 1.0.2: histogram_statistics() has a skewness of 0 and a kurtosis of -1.2 for every image.
# They are those of the middles of the bins, which are evenly spaced, and not of the gray values. "nbins" does not matter.
# Seen: gray values of an exponential distribution have 0 and -1.200; right are 2 and 6. A label image with 95 % of its voxels
# in one phase has the same; right are -4.13 and 15.1. Mean and variance are right.
# Fix: scipy.stats.skew() and kurtosis() of image.ravel().
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps dpm-tools==1.0.2 pyfftw==0.15.1 dpm-srg==0.0.5 dpm-srm==0.1.9 netcdf4==1.7.5.1.post1 cftime==1.6.6.1 certifi==2026.10.19.post1 h5py==3.16.0 wget==3.2 exifread==3.5.1 scikit-fmm==2025.6.23 requests==2.34.2 urllib3==2.8.0 idna==3.20 charset-normalizer==3.5.3 porespy==3.2.0 scikit-image==0.26.0 scipy==1.17.1 numba==0.68.1 llvmlite==0.50.0 numpy==2.4.6 edt==3.0.0 connected-components-3d==4.1.1 dask==2026.8.0 cloudpickle==3.1.3 fsspec==2026.9.0 toolz==1.2.0 partd==1.4.2 locket==1.0.0 pyyaml==6.0.4 importlib-metadata==10.2.0 zipp==4.1.2 deprecated==1.3.1 wrapt==2.5.2 imageio==2.38.1 pillow==13.0.0 lazy-loader==0.6 lazy-importer==0.1.0 tifffile==2026.3.3 pandas==3.1.1 python-dateutil==4.0.0 six==1.17.0 networkx==3.6.1 packaging==26.4 matplotlib==3.11.2 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 pyparsing==3.3.3 tqdm==4.70.1 psutil==7.2.2 pooch==1.9.0 platformdirs==4.14.9 pyvista==0.49.1 pyvista-validation==0.2.2 scooby==0.12.1 typing-extensions==4.16.0 vtk==9.7.2 loguru==0.7.3 rich==15.0.0 jinja2==3.1.6 markupsafe==3.0.4
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import contextlib
import importlib.metadata
import io

import numpy as np
from dpm_tools.metrics import histogram_statistics

# The quantiles of an exponential distribution, whose skewness is 2 and whose kurtosis is 6 above that of a normal one.
count = 100**3
exponential = -np.log(1 - (np.arange(count) + 0.5) / count).reshape(100, 100, 100)
labels = (np.arange(count) % 20 > 0).astype(np.uint8).reshape(100, 100, 100)
share = 0.95
right = {
    "exponential": (1, 1, 2, 6),
    "labels": (share, share * (1 - share), (1 - 2 * share) / (share * (1 - share)) ** 0.5, 1 / (share * (1 - share)) - 6),
}
print("dpm-tools", importlib.metadata.version("dpm-tools"))
for name, image in (("exponential", exponential), ("labels", labels)):
    with contextlib.redirect_stdout(io.StringIO()):
        statistics = histogram_statistics(image)[0]
    seen = [float(statistics[key]) for key in ("mean", "variance", "skewness", "kurtosis")]
    moments = (image - image.mean()) / image.std()
    own = float((moments**3).mean()), float((moments**4).mean() - 3)
    print(f"  {name}: skewness and kurtosis {seen[2]:.3f}, {seen[3]:.3f}, of the gray values {own[0]:.3f}, {own[1]:.3f}")
    assert np.allclose(seen[:2], right[name][:2], rtol=1e-3) and np.allclose(own, right[name][2:], rtol=0.01)
    assert abs(seen[2]) < 1e-9 and abs(seen[3] + 1.2) < 1e-3
PYTHON
