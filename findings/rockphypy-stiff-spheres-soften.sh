#!/usr/bin/env bash
# rockphypy 0.0.2: EM.Berryman_DEM() of spheres stiffer than the matrix lowers the shear modulus.
# Seen: 30 % of (K, G) = (50, 30) in (20, 12) give (26.51, 9.64); the differential scheme gives (25.81, 15.65).
# Empty pores are wrong, too: (12.17, 5.49) for (9.14, 5.95).
# Mends it: integrate dK = (Ki - K) P / (1 - t) and dG = (Gi - G) Q / (1 - t) with P and Q of EM.PQ(K, G, Ki, Gi, alpha).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile rockphypy==0.0.2 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from rockphypy import EM
from scipy.integrate import solve_ivp


def spheres(K, G, Ki, Gi):
    z = G / 6 * (9 * K + 8 * G) / (K + 2 * G)
    return (K + 4 / 3 * G) / (Ki + 4 / 3 * G), (G + z) / (Gi + z)


def scheme(Ki, Gi, factors):
    def rate(t, y):
        P, Q = factors(y[0], y[1], Ki, Gi)
        return [(Ki - y[0]) * P / (1 - t), (Gi - y[1]) * Q / (1 - t)]

    return np.round(solve_ivp(rate, (0, 0.3), [20.0, 12.0], rtol=1e-9, atol=1e-9).y[:, -1], 2).tolist()


seen = {}
for name, Ki, Gi in (("stiff", 50.0, 30.0), ("pores", 0.0, 0.0)):
    bulk, shear, _ = EM.Berryman_DEM(20.0, 12.0, Ki, Gi, 1, 0.3)
    right = scheme(Ki, Gi, spheres)
    assert right == scheme(Ki, Gi, lambda *phases: EM.PQ(*phases, 1))
    seen[name] = [round(float(bulk[-1]), 2), round(float(shear[-1]), 2)], right
print("rockphypy", importlib.metadata.version("rockphypy"), "K and G seen, right:", seen)
assert seen == {"stiff": ([26.51, 9.64], [25.81, 15.65]), "pores": ([12.17, 5.49], [9.14, 5.95])}
PYTHON
