#!/usr/bin/env bash
# revarie 1.4.0: Variogram.matheron() returns the mean of squared differences as semivariance, which is half of it.
# Revarie() takes the sill for the variance of the field, so that fields by a model of its own variogram correlate too little.
# Bins without pairs are left out of the values but not of the centres, so that values stand at other lags.
# Seen: heights 0, 1, 2, ... at steps of 1 have 1, 4, 9 at lags of 1, 2, 3; right by Matheron are 0.5, 2, 4.5. Independent
# values of variance 4 have a plateau of 8. Points whose correlation is 0.5 have 0 in Revarie(). At steps of 2, four bins have
# two values, the second of them of lag 4. No message.
# Fix: halves of the values; bins that have pairs (n_bins > 0).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile revarie==1.4.0 numpy-indexed==0.3.7 scipy==1.14.1 numpy==1.26.4
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata
import warnings

import numpy as np
from revarie import Revarie, Variogram, fvariogram

print("revarie", importlib.metadata.version("revarie"))
heights = np.arange(60.0)
bounds = [0.5, 1.5, 2.5, 3.5]
centers, counts, values = Variogram(heights, heights).matheron("bound", bounds)
right = np.array([np.mean((heights[k:] - heights[:-k]) ** 2) / 2 for k in (1, 2, 3)])
print(f"  a ramp at lags {centers}: {values}, right {right}")
assert np.array_equal(values, [1, 4, 9]) and np.array_equal(right, [0.5, 2, 4.5])

rng = np.random.default_rng(1)
places, field = rng.random((700, 2)), rng.normal(0, 2, 700)
lags, _, noise = Variogram(places, field).matheron()
print(f"  noise of variance {field.var():.3f}: {noise.round(2)}")
assert np.allclose(noise, 2 * field.var(), rtol=0.06)

# a model of it, given to the generator of fields with the variance of the field, where half of the correlation is left
far = 0.1 * np.log(2) / 3
correlations = []
for sill in (noise.mean(), noise.mean() / 2):
    model = fvariogram("func", "exp", [0.0, float(sill), 0.1])
    covariance = Revarie(np.array([[0.0, 0.0], [far, 0.0]]), 0.0, field.var(), model).cov
    correlations.append(covariance[0, 1] / covariance[0, 0])
print("  correlation {:.3f}, with halves {:.3f}, right 0.5".format(*correlations))
assert abs(correlations[0]) < 0.02 and np.isclose(correlations[1], 0.5, atol=0.02)

even = np.arange(0, 60.0, 2)
centers, counts, values = Variogram(even, even).matheron("bound", bounds + [4.5])
print(f"  at steps of 2: lags {centers}, pairs {counts}, values {values}")
assert len(centers) == 4 and list(counts) == [0, 29, 0, 28] and np.array_equal(values, [4, 16])
PYTHON
