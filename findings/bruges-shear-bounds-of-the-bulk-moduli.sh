#!/usr/bin/env bash
# bruges 0.5.4: hashin_shtrikman(..., modulus="shear") puts the bulk moduli into the bounds of the shear modulus.
# Seen: 70 % of (K, G) = (20, 12) and 30 % of (50, 30) have shear bounds of 25.47 and 26.39; right are 15.57 and 16.18.
# Both answers lie above the mean of the shear moduli, 17.4, which nothing isotropic exceeds. The bounds of K are right.
# Mends it: 1 / sum(f / (mu + z)) - z with z = mu (9 k + 8 mu) / (k + 2 mu) / 6 of the softest and the stiffest phase.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile bruges==0.5.4 scipy==1.17.1 matplotlib==3.11.2 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from bruges.rockphysics import hashin_shtrikman

share, bulk, shear = np.array([0.7, 0.3]), np.array([20.0, 50.0]), np.array([12.0, 30.0])


def bound(values, z):
    return 1 / np.sum(share / (values + z)) - z


bulk_bounds = [bound(bulk, 4 / 3 * g) for g in shear]
shear_bounds = [bound(shear, g / 6 * (9 * k + 8 * g) / (k + 2 * g)) for k, g in zip(bulk, shear)]
mixed = [bound(bulk, g / 6 * (9 * k + 8 * g) / (k + 2 * g)) for k, g in zip(bulk, shear)]
seen = {name: [float(x) for x in hashin_shtrikman(share, bulk, shear, modulus=name)] for name in ("bulk", "shear")}
print("bruges", importlib.metadata.version("bruges"), seen, "right:", np.round(bulk_bounds, 4), np.round(shear_bounds, 4))
assert np.allclose(seen["bulk"], bulk_bounds)
assert np.allclose(seen["shear"], mixed) and min(seen["shear"]) > share @ shear > max(shear_bounds)
PYTHON
