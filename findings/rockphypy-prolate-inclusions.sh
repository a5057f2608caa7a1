#!/usr/bin/env bash
# rockphypy 0.0.2: EM.PQ() of prolate inclusions (aspect ratio above 1) has 1 / cosh where the inverse of cosh belongs.
# Seen: at 0.99 and 1.01 a stiff grain has Q = 0.577 and 0.00006; right are 0.577 and 0.577. Oblate ones and spheres fit.
# EM.Berryman_sc() repeats it: 30 % of these grains in softer matter give G = 15.74 at 0.99 and 0 at 1.01.
# Mends it: theta = a (a sqrt(a a - 1) - arccosh(a)) / (a a - 1)^1.5 in PQ() and PQ_vectorize().
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile rockphypy==0.0.2 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from rockphypy import EM

K, G, stiff_K, stiff_G = 20.0, 12.0, 50.0, 30.0
near = {a: [round(float(x), 5) for x in EM.PQ(K, G, stiff_K, stiff_G, a)] for a in (0.99, 1, 1.01)}
phases = np.array([K, stiff_K]), np.array([G, stiff_G]), np.array([0.7, 0.3])
mixed = {a: [round(float(x), 2) for x in EM.Berryman_sc(*phases, np.full(2, a))] for a in (0.99, 1.01)}

cosh = np.cosh
np.cosh = lambda x: 1 / np.arccosh(x)  # PQ takes its inverse, so that this is arccosh in its place.
try:
    mended = [round(float(x), 5) for x in EM.PQ(K, G, stiff_K, stiff_G, 1.01)]
finally:
    np.cosh = cosh
print("rockphypy", importlib.metadata.version("rockphypy"), "P and Q by aspect ratio:", near, "with arccosh at 1.01:", mended)
print("K and G of 30 % in 70 % by Berryman_sc:", mixed)
assert near[0.99] == [0.54546, 0.57692] and near[1.01] == [1.16871, 0.00006]
assert max(abs(a - b) for a, b in zip(mended, near[1])) < 1e-4
assert mixed[0.99] == [25.95, 15.74] and not mixed[1.01][1] > 1
PYTHON
