#!/usr/bin/env bash
# rfgen 0.2.3: spectral moments of a field are divided by its number of points, so that the rms height falls with the size.
# m00 is documented as the variance and m20 as that of the slope. The squared spectrum sums up to the variance already and is
# multiplied by the area of a cell of wave numbers on top, 1 / (Nx Ny h^2). rms_quantities() takes the roots of it.
# summit_density_estimate() has the root of m4 / m2, a number per length; Nayak's density per area has m4 / m2 itself.
# Seen: a wave of amplitude 1 has an rms height of 0.0110 on 64 x 64 points a distance of 1 apart, 0.110 at 0.1 and 0.0055 on
# 128 x 128; right is 0.707. Slopes and curvatures are off by the same factor, which cancels in nayak_parameter().
# An isotropic field of 512 x 512 points has 281 summits, by rfgen 1522, by Nayak's form 289.
# Fix: multiply moments by Nx Ny h^2; (m40 + m04) / (m20 + m02) / (6 pi sqrt(3)) for the density of summits.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile rfgen==0.2.3 matplotlib==3.11.2 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
import rfgen
from rfgen import analysis

print("rfgen", importlib.metadata.version("rfgen"))
for size, spacing in ((64, 1.0), (64, 0.1), (128, 1.0)):
    wave = np.tile(np.sin(2 * np.pi * 4 * np.arange(size) / size), (size, 1))
    slope = 2 * np.pi * 4 / (size * spacing) * np.sqrt(0.5)
    seen = analysis.rms_quantities(wave, spacing)
    print(f"  {size} x {size} at {spacing}: rms height {seen['rms_height']:.4f}, right {wave.std():.4f};", end=" ")
    print(f"slope {seen['rms_slope_x']:.4f}, right {slope:.4f}")
    assert np.isclose(wave.std(), np.sqrt(0.5))
    assert np.isclose(seen["rms_height"], wave.std() / (size * spacing))
    assert np.isclose(seen["rms_slope_x"], slope / (size * spacing))
    assert np.isclose(analysis.spectral_moment(wave, 0, 0, spacing) * (size * spacing) ** 2, wave.var())

field = rfgen.selfaffine_field(dim=2, N=512, Hurst=0.8, k_low=0.02, k_high=0.05, rng=np.random.default_rng(0))
shifts = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]
counted = int(np.all([field > np.roll(field, shift, (0, 1)) for shift in shifts], axis=0).sum())
moments = analysis.rms_quantities(field)
quotient = (moments["rms_curvature"] / moments["rms_slope"]) ** 2
nayak = quotient / (6 * np.pi * np.sqrt(3)) * field.size
estimate = analysis.summit_density_estimate(field) * field.size
print(f"  summits: {counted} counted, {estimate:.0f} by rfgen, {nayak:.0f} by Nayak")
assert np.isclose(nayak, counted, rtol=0.1) and estimate > 5 * counted
assert np.isclose(estimate, nayak / np.sqrt(quotient))
PYTHON
