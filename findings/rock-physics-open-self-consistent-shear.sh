#!/usr/bin/env bash
# rock-physics-open 1.0.1: the self-consistent models end when the bulk modulus settles; they do not look at the shear modulus.
# These are self_consistent_approximation_model() and multi_sca(). "tol" does not help where the bulk moduli are alike.
# Seen: half of (K, G) = (37, 44) and half of (37, 5) have G = 16.84 at any tolerance; 15.40 solves the equations.
# (40, 5) in place of the second has 16.87 at a tolerance of 1e-3, where K is within 2e-4; right is 15.43.
# Mends it: K of the phases apart by a share of 1e-4 and a tolerance of 1e-12.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile rock-physics-open==1.0.1 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from rock_physics_open.shale_models import multi_sca, self_consistent_approximation_model
from scipy.optimize import root

one = np.ones(1)


def seen(K, G, tol):
    a, b, half = (37e9 * one, 44e9 * one, one), (K * one, G * one, one), 0.5 * one
    two = self_consistent_approximation_model(*a, *b, half, one, one, tol)
    many = multi_sca(*a, one, half, *b, one, half, tol=tol)
    assert np.allclose(two[:2], many[:2])
    return np.ravel(two[:2]) / 1e9


def right(K, G):
    phases = np.array([[37.0, 44.0], [K / 1e9, G / 1e9]])

    def excess(y):
        k, g = y
        around = np.array([4 / 3 * g, g / 6 * (9 * k + 8 * g) / (k + 2 * g)])
        return ((phases - y) / (phases + around)).sum(axis=0)

    return root(excess, phases.mean(axis=0), tol=1e-12).x


print("rock-physics-open", importlib.metadata.version("rock-physics-open"))
for K, tol, K_seen, G_seen, K_right, G_right in (
    (37e9, 1e-3, 37, 16.836, 37, 15.396),
    (37e9, 1e-9, 37, 16.836, 37, 15.396),
    (40e9, 1e-3, 38.468, 16.867, 38.462, 15.429),
    (37.004e9, 1e-12, 37.002, 15.396, 37.002, 15.396),
):
    own, solved = seen(K, 5e9, tol), right(K, 5e9)
    print(" second K", K / 1e9, "tolerance", tol, "K and G seen:", own.round(3), "right:", solved.round(3))
    assert np.allclose(own, [K_seen, G_seen], atol=2e-3) and np.allclose(solved, [K_right, G_right], atol=2e-3)
PYTHON
