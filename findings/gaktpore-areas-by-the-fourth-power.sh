#!/usr/bin/env bash
# GAKTpore 1.1.2: process() multiplies the area of a pore by the fourth power of the scale, process_parallel() by the second.
# The areas of contours are scaled, then summed up to pores and scaled once more; the radius of an equal circle gets the
# square of the scale in this way. The largest inscribed circle has it once, and so have the territories of
# process_free_area(), so that the local share of pores is off by the square as well.
# Rings of process_radial_contour() have the share of the solid as "porosity"; total_porosity is right.
# Seen: a round pore of 30 pixels in an image of 2 um per pixel has 45 992 um2 and a radius of 121 um; right are 11 498 um2
# and 60.5 um, and pi 60^2 = 11 310. Rings that have 100, 41.8 and 0.9 % of pores have 0, 58.2 and 99.1 %.
# Fix: process_parallel(), or a scale of 1 and own factors; 1 - radius_porosity.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile GAKTpore==1.1.2 opencv-python==4.8.1.78 pyFFTW==0.13.1 scikit-image==0.21.0 matplotlib==3.7.5 psutil==7.2.2 scipy==1.10.1 numpy==1.23.5
cd "$folder"
cat > pores.py <<'PYTHON'
import importlib.metadata
import warnings

import GAKTpore
import numpy as np

warnings.filterwarnings("ignore")  # arrays of contours of different lengths
y, x = np.indices((200, 200))
image = np.full(x.shape, 255, np.uint8)
for row, column, radius in ((100, 100, 30), (40, 40, 20), (150, 50, 15)):
    image[(y - row) ** 2 + (x - column) ** 2 <= radius**2] = 0


def measure(scale, parallel):
    pores = GAKTpore.AnalysePores(image, scale=scale, cpu_count=1)
    pores.process_parallel() if parallel else pores.process()
    pores.process_free_area()
    return pores


def main():
    print("GAKTpore", importlib.metadata.version("GAKTpore"))
    for scale in (1.0, 2.0):
        one, many = measure(scale, False), measure(scale, True)
        print(f"  scale {scale}: areas {one.area.round(0)}, in parallel {many.area.round(0)}, radii {one.area_rad.round(1)}")
        print(f"    in parallel {many.area_rad.round(1)}, of the largest circle inside {one.l_rad.round(1)}")
        assert np.allclose(one.area, many.area * scale**2) and np.allclose(one.area_rad, many.area_rad * scale)
        assert np.allclose(one.l_rad, many.l_rad) and np.allclose(one.homogeneity_areas, many.homogeneity_areas)
        assert np.isclose(many.area.max(), np.pi * (30 * scale) ** 2, rtol=0.03)
        assert np.allclose(many.area_rad, many.l_rad, rtol=0.03)
        one.process_radial_contour(radii_n=5)
        distance = np.hypot(y - 100, x - 100)
        rings = np.array([np.mean(image[(distance >= r) & (distance < r + 20)] == 0) for r in (0, 20, 40, 60)])
        seen = np.array(one.radius_porosity)[:4]
        print(f"    pores in rings {rings.round(3)}, seen {seen.round(3)}, in all {one.total_porosity} %")
        assert np.allclose(seen, 1 - rings) and np.isclose(one.total_porosity, 100 * np.mean(image == 0))


if __name__ == "__main__":
    main()
PYTHON
"$folder/venv/bin/python" pores.py
