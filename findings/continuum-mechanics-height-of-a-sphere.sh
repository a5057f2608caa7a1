#!/usr/bin/env bash
# continuum-mechanics 0.2.2: transform_coords("spherical", (r, theta, phi)) has r sin(theta) as z, which is r cos(theta).
# The points of a sphere then lie on a cone at 45 degrees. scale_coeff() of that transform differs from
# scale_coeff_coords() of the same module, which is right and which grad() and others want as h_vec.
# Seen: the point (2, pi / 3, 0) lies 2.449 from the origin, not 2, and a unit ball has a volume of 0, not 4 pi / 3.
# Scale factors are wrong in turn for other coordinates whose transform is right: the third of "oblate_spheroidal" and of
# "prolate_spheroidal" are exchanged, and "bispherical" has sin(v) for sin(u). Five other systems agree.
# Fix: scale_coeff() of transform_coords() for these three, scale_coeff_coords() for "spherical".
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps continuum-mechanics==0.2.2 sympy==1.14.0 mpmath==1.3.0
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import sympy
from continuum_mechanics.vector import scale_coeff_coords, transform_coords

u, v, w = coordinates = sympy.symbols("u v w", positive=True)
place = {u: 0.7, v: 0.9, w: 0.4}


def scales(name):
    jacobian = sympy.Matrix(transform_coords(name, coordinates)).jacobian(coordinates).subs(place)
    own = [float(jacobian[:, i].norm()) for i in range(3)]
    table = [float(sympy.sympify(scale).subs(place)) for scale in scale_coeff_coords(name, coordinates)]
    return own, table


def close(first, second):
    return all(abs(a - b) < 1e-9 for a, b in zip(first, second))


print("continuum-mechanics", importlib.metadata.version("continuum-mechanics"))
sphere = sympy.Matrix(transform_coords("spherical", coordinates))
distance = float(sphere.subs({u: 2, v: sympy.pi / 3, w: 0}).norm())
whole = ((u, 0, 1), (v, 0, sympy.pi), (w, 0, 2 * sympy.pi))
ball = sympy.integrate(sympy.simplify(sphere.jacobian(coordinates).det()), *whole)
right = sympy.integrate(sympy.prod(scale_coeff_coords("spherical", coordinates)), *whole)
print("  spherical:", tuple(sphere), "distance of (2, pi / 3, 0):", round(distance, 3), "ball:", ball, "by the table:", right)
assert abs(distance - 6**0.5) < 1e-9 and sympy.simplify(ball) == 0 and sympy.simplify(right - 4 * sympy.pi / 3) == 0
for name in ("spherical", "oblate_spheroidal", "prolate_spheroidal", "bispherical"):
    own, table = scales(name)
    print(f"  {name}: of the transform {[round(x, 4) for x in own]}, in the table {[round(x, 4) for x in table]}")
    assert not close(own, table)
assert close(scales("oblate_spheroidal")[0], scales("prolate_spheroidal")[1])
assert close(scales("oblate_spheroidal")[1], scales("prolate_spheroidal")[0])
for name in ("cylindrical", "parabolic", "toroidal", "elliptic_cylindrical", "bipolar_cylindrical"):
    assert close(*scales(name))
PYTHON
