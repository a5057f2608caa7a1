#!/usr/bin/env bash
# fick1d 0.0.2: sphere.mean() has a sphere fuller than its surface, slab.mean() empties what fills, cylinder() goes below zero.
# Means: a sphere has plus 2 before its sum in place of minus 6/pi^2; a slab starts at the outer value and ends at the initial one.
# A cylinder has the root of the radius where the radius belongs, and leaves out the second zero of J0. By Crank, "The
# Mathematics of Diffusion", equations 4.18, 5.22 and 6.20; profiles of slab() and sphere() agree with his.
# Seen, 0 inside and 1 at the surface: at D t = 0.05 R^2 a sphere has a mean of 2.29, right is 0.607; at D t = 0.0125 h^2 a slab
# has 0.748, right is 0.252; at D t = 0.05 R^2 the axis of a cylinder has -5.10 for a radius of 25 and -0.22 for one of 1, right
# is 0.013. Initial values of chloride or moisture come back after a long time. No message.
# Fix: means from the profiles, or the series as here.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile fick1d==0.0.2 scipy==1.14.1 numpy==1.26.4 matplotlib==3.9.4
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from fick1d import cylinder, slab, sphere
from scipy.special import j0, j1, jn_zeros

n, m = np.arange(1, 2000), 2 * np.arange(2000) + 1
times = np.array([0.001, 0.05, 0.2, 2.0])  # D t / R^2, of half the thickness for a slab
size, diffusivity = 25.0, 0.01
seconds = list(times * size**2 / diffusivity)
print("fick1d", importlib.metadata.version("fick1d"))

ball = sphere.mean(seconds, size, diffusivity, 0.0, 1.0)
right_ball = np.array([1 - 6 / np.pi**2 * np.sum(np.exp(-t * (n * np.pi) ** 2) / n**2) for t in times])
plate = slab.mean(seconds, 2 * size, diffusivity, 0.0, 1.0)
right_plate = np.array([1 - 8 / np.pi**2 * np.sum(np.exp(-t * (m * np.pi / 2) ** 2) / m**2) for t in times])
for t, *values in zip(times, ball, right_ball, plate, right_plate):
    print("  D t / R^2 = {}: sphere {:.3f}, right {:.3f}; slab {:.3f}, right {:.3f}".format(t, *values))
assert ball[0] > 3.9 and np.all(np.diff(ball) < 0) and np.isclose(ball[1], 2.2931, atol=1e-4)
assert np.isclose(right_ball[1], 0.6069, atol=1e-4)
assert np.allclose(plate, 1 - right_plate, atol=1e-6) and plate[0] > 0.96 and plate[-1] < 0.01

# the means of the profiles of the same package
r = np.linspace(0, size, 401)
profile = sphere.sphere(seconds[1:3], size, diffusivity, 0.0, 1.0, rstep=401)
assert np.allclose(np.trapz(3 * profile * r**2, r) / size**3, right_ball[1:3], atol=1e-4)
profile = slab.slab(seconds[1:3], 2 * size, diffusivity, 0.0, 1.0, xstep=401)
assert np.allclose(np.trapz(profile, dx=1 / 400), right_plate[1:3], atol=1e-3)


def column(radius, zeros):
    places = np.linspace(0, 1, 6)
    sums = [np.sum(np.exp(-t * zeros**2) * j0(np.outer(places, zeros)) / (zeros * j1(zeros)), axis=1) for t in times[1:3]]
    own = cylinder.cylinder(list(times[1:3] * radius**2 / diffusivity), radius, diffusivity, 0.0, 1.0, rstep=6)
    return own, np.array(sums)


zeros = jn_zeros(0, 90)
for radius in (1.0, 25.0):
    own, sums = column(radius, zeros)
    right = 1 - 2 * sums
    print(f"  cylinder of {radius:g} at D t / R^2 = 0.05 from the axis: {own[0].round(3)}, right {right[0].round(3)}")
    assert own[0, 0] < -0.2 and 0.01 < right[0, 0] < 0.02
    _, fewer = column(radius, np.delete(zeros, 1))
    assert np.allclose(own[:, :-1], (1 - 2 * np.sqrt(radius) * fewer)[:, :-1], atol=1e-3)
PYTHON
