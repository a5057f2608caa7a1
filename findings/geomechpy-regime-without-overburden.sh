#!/usr/bin/env bash
# geomechpy 0.0.7: calculate_poroelastic_horizontal_stresses() reports the regime of a vertical stress of 0.
# By its documentation the factor is in 0..1 where the vertical stress is largest (normal faulting), in 1..2 where it is in
# between and in 2..3 where it is least (reverse faulting). The overburden is at hand and enters the horizontal stresses.
# Seen: 10000 psi above horizontal stresses of 6333 psi have a factor of 3.000; calculate_stress_regime_q_factor() has 0.0001
# for these three stresses. Equal horizontal stresses have 4, which stands for none of the three regimes.
# Strains enter a thousand times too weakly for the stated units as well: E of 3 Mpsi and strains of 0.0001 and 0.0002 add
# 0.48 and 0.72 psi to the stresses of the same rock without strain; right are 480 and 720 psi.
# Fix: calculate_stress_regime_q_factor(overburden, shmax, shmin), and strains times 1000.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps geomechpy==0.0.7 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from geomechpy.stress_calculations import HorizontalStressesCalculation as calculation

overburden, pore, poisson, young = 10000.0, 4500.0, 0.25, 3.0
strains = np.array([1e-4, 2e-4])
at_rest = calculation.calculate_poroelastic_horizontal_stresses(overburden, pore, poisson, young, 1.0, 0.0, 0.0)
seen = calculation.calculate_poroelastic_horizontal_stresses(overburden, pore, poisson, young, 1.0, *strains)
own = calculation.calculate_stress_regime_q_factor(overburden, seen.shmax, seen.shmin)
rest = poisson / (1 - poisson) * (overburden - pore) + pore
added = np.array([seen.shmin, seen.shmax]) - [at_rest.shmin, at_rest.shmax]
right = young * 1e6 / (1 - poisson**2) * (strains + poisson * strains[::-1])
print("geomechpy", importlib.metadata.version("geomechpy"), seen, "factor of the three stresses:", round(own, 6))
print("equal stresses:", at_rest.q_factor, "added by strain:", added.round(3), "right:", right.round(3))
assert np.allclose([at_rest.shmin, at_rest.shmax], rest)
assert np.isclose(seen.q_factor, 2 + seen.shmin / seen.shmax) and 0 < own < 0.001
assert at_rest.q_factor == 4
assert np.allclose(added * 1000, right)
PYTHON
