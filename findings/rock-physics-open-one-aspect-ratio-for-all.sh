#!/usr/bin/env bash
# rock-physics-open 1.0.1: dem_model() gives all samples with the same moduli the aspect ratio of the first.
# It gathers equal moduli before it integrates, and leaves the aspect ratios as they were.
# Seen: 10 % of pores of the aspect ratios 0.01, 0.1 and 1 in one call have K = 0.33 GPa three times.
# One by one they have 0.33, 20.98 and 30.36 GPa; 30.36 is that of an own integration for spheres.
# Mends it: one call for each aspect ratio.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile rock-physics-open==1.0.1 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from rock_physics_open.shale_models import dem_model
from scipy.integrate import solve_ivp

K, G, share = 36e9, 45e9, 0.1


def seen(aspects):
    aspects, one = np.array(aspects), np.ones(len(aspects))
    return dem_model(K * one, G * one, 2650 * one, 0 * one, 0 * one, 0 * one, share * one, aspects, 1e-9)[:2]


def rate(t, y):
    k, g = y
    z = g / 6 * (9 * k + 8 * g) / (k + 2 * g)
    return [-k * (k + 4 / 3 * g) / (4 / 3 * g) / (1 - t), -g * (g + z) / z / (1 - t)]


spheres = solve_ivp(rate, (0, share), [K, G], rtol=1e-10).y[:, -1]
aspects = [0.01, 0.1, 1.0]
together = np.array(seen(aspects)).T
alone = np.array([np.ravel(seen([aspect])) for aspect in aspects])
print("rock-physics-open", importlib.metadata.version("rock-physics-open"), "K, G of", aspects, "in GPa")
print(" in one call:", np.round(together / 1e9, 2).tolist(), "one by one:", np.round(alone / 1e9, 2).tolist())
assert np.allclose(alone[2], spheres, rtol=1e-6)
assert np.allclose(together, alone[0], rtol=1e-6) and alone[2, 0] > 90 * alone[0, 0]
PYTHON
