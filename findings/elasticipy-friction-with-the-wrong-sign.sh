#!/usr/bin/env bash
# Elasticipy 7.0.0: MohrCoulomb(c, phi) and DruckerPrager.from_cohesion_friction_angle(c, phi) have friction in reverse.
# Stresses are positive in tension, as from_tensile_compression_stress() of both takes them; the terms of friction, in
# the code and the docstrings, are those of stresses that are positive in compression.
# Seen: c = 1 and phi = 30 degrees yield at 3.464 in tension and 1.155 in compression; right is the reverse.
# A hydrostatic compression of 10 yields, a tension of 10 does not. Concrete of 3 and -30 comes back with phi = -54.9.
# Mends it: -phi for phi, or from_tensile_compression_stress().
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile elasticipy==7.0.0 numpy==2.2.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from elasticipy.tensors.stress_strain import StressTensor
from elasticipy.yield_criteria import DruckerPrager, MohrCoulomb
from scipy.optimize import brentq

c, phi = 1.0, np.radians(30)
# A circle of Mohr through 0 that touches the line tau = c - sigma tan(phi), tension positive.
tension, compression = 2 * c * np.cos(phi) / (1 + np.sin(phi)), 2 * c * np.cos(phi) / (1 - np.sin(phi))


def strengths(criterion):
    def excess(stress):
        return float(criterion.yield_function(StressTensor.tensile([1, 0, 0], stress)))

    return round(brentq(excess, 1e-6, 100), 3), round(brentq(lambda stress: excess(-stress), 1e-6, 100), 3)


def yields(criterion, pressure):
    return bool(criterion.yield_function(StressTensor(-pressure * np.eye(3))) > 0)


print("Elasticipy", importlib.metadata.version("elasticipy"), "right:", np.round([tension, compression], 3))
for sign in (1, -1):
    coulomb = MohrCoulomb(c, sign * 30)
    prager = DruckerPrager.from_cohesion_friction_angle(c, sign * 30, fit="outside")
    print(" phi", sign * 30, "strengths in tension and compression:", strengths(coulomb), strengths(prager))
    assert strengths(coulomb) == (3.464, 1.155)[::sign]
    assert strengths(prager) == ((2.078, 1.155), (1.485, 3.464))[sign < 0]
    for criterion in (coulomb, prager):
        assert (yields(criterion, 10), yields(criterion, -10)) == (sign > 0, sign < 0)
concrete = MohrCoulomb.from_tensile_compression_stress(3, -30)
print(" tension 3 and compression -30:", strengths(concrete), "phi", round(float(np.degrees(concrete.phi)), 1))
assert strengths(concrete) == (3, 30) and round(float(np.degrees(concrete.phi)), 1) == -54.9
PYTHON
