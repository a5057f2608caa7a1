#!/usr/bin/env bash
# opensection 1.0.0: contours lose their signs; a clockwise hole attracts the centroid; I_yz of one is never negative.
# The documentation wants outer contours counterclockwise and holes clockwise. The area is taken without its sign, the sums
# for the centroid with it, so that the centroid of a clockwise hole is mirrored at the origin.
# Seen: a square of 4 with a hole of 1 around (2.5, 2.5) has its centroid at (2.3, 2.3) and second moments of -25.35; right
# are (1.967, 1.967) and 20.98, which a hole against the documentation, counterclockwise, has.
# Two triangles that mirror each other have I_yz of 2 both; right are -2 and 2, so that principal axes are on the wrong side.
# Fix: holes counterclockwise; no fix for I_yz but an own sum.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps opensection==1.0.0 matplotlib==3.11.2 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 packaging==26.4 pillow==13.0.0 pyparsing==3.3.3 python-dateutil==4.0.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from opensection.geometry.contour import Contour, Point
from opensection.geometry.section import Section


def contour(points, hole=False):
    return Contour([Point(*point) for point in points], is_hole=hole)


def square(low, high):
    return [(low, low), (high, low), (high, high), (low, high)]


def numbers(*contours):
    found = Section(list(contours)).properties
    return np.array([*found.centroid, found.I_yy, found.I_zz, found.I_yz], float)


clockwise = numbers(contour(square(0, 4)), contour(square(2, 3)[::-1], hole=True))
counter = numbers(contour(square(0, 4)), contour(square(2, 3), hole=True))
center = (16 * 2 - 1 * 2.5) / 15
second = 4**4 / 12 + 16 * (2 - center) ** 2 - 1 / 12 - (2.5 - center) ** 2
right = numbers(contour([(0, 0), (3, 0), (0, 4)]))
left = numbers(contour([(0, 0), (0, 4), (-3, 0)]))
print("opensection", importlib.metadata.version("opensection"), "right:", round(center, 4), round(second, 4))
print("hole clockwise:", clockwise.round(4), "counterclockwise:", counter.round(4))
print("triangles:", right.round(4), left.round(4))
assert np.allclose(counter[:4], [center, center, second, second])
assert np.allclose(clockwise[:4], [2.3, 2.3, -25.35, -25.35])
# The product of inertia of a right triangle with legs b and h along the axes is -b^2 h^2 / 72 about its centroid.
assert np.isclose(right[4], 3**2 * 4**2 / 72) and np.isclose(left[4], right[4])
assert np.allclose(right[:2], [1, 4 / 3]) and np.allclose(left[:2], [-1, 4 / 3])
PYTHON
