#!/usr/bin/env bash
# simcoon 2.2.0: Eshelby_penny() has the shears of a crack at the places of another order of components.
# simcoon has 11, 22, 33, 12, 13, 23; the ones are at 13 and 23, as if it had 11, 22, 33, 23, 13, 12, and so in its docstring.
# Seen: a flat crack across axis 1 opens to the shears 12 and 13. Eshelby_oblate() of the aspect ratio 1e-6 and the numerical
# Eshelby() have that; Eshelby_penny() has 0 for 12 and 1 for 23, a shear in the plane of the crack.
# Mends it: Eshelby_oblate(nu, 1e-6).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile simcoon==2.2.0 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
import simcoon
from scipy.integrate import quad

nu, flat = 0.2, 1e-3
axes = np.array([flat, 1.0, 1.0])


def integral(*which):
    def rate(s):
        return np.prod(axes) / (np.prod([axes[i] ** 2 + s for i in which]) * np.sqrt(np.prod(axes**2 + s)))

    edges = [0, flat**2, flat, 1, np.inf]
    return 2 * np.pi * sum(quad(rate, *pair, epsabs=0, epsrel=1e-10)[0] for pair in zip(edges, edges[1:]))


def shear(i, j):
    own = (axes[i] ** 2 + axes[j] ** 2) * integral(i, j) + (1 - 2 * nu) * (integral(i) + integral(j))
    return own / (8 * np.pi * (1 - nu))


own = np.array([shear(0, 1), shear(0, 2), shear(1, 2)])
penny = np.diag(simcoon.Eshelby_penny(nu))[3:]
flattened = np.diag(simcoon.Eshelby_oblate(nu, flat))[3:]
numerical = np.diag(simcoon.Eshelby(simcoon.L_iso([30e3, nu], "Enu"), flat, 1.0, 1.0, 200, 200))[3:]
limit = np.diag(simcoon.Eshelby_oblate(nu, 1e-6))[3:]
print("simcoon", importlib.metadata.version("simcoon"), "shears 12, 13, 23 of the penny:", penny, "of 1e-6:", limit.round(4))
print(" of 1e-3:", flattened.round(4), "by simcoon's integration:", numerical.round(4), "by own integrals:", own.round(4))
assert np.allclose(flattened, own, atol=1e-6) and np.allclose(numerical, own, atol=0.02)
assert np.allclose(limit, [1, 1, 0], atol=1e-4) and penny.tolist() == [0, 1, 1]
PYTHON
