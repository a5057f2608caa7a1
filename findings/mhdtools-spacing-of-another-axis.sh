#!/usr/bin/env bash
# mhdtools 1.0.1: slices along x come with the spacing and origin of y, and slices along y with those of x.
# load(name, "sagittal") returns slices along x and the spacing of index 1, load(name, "coronal") slices along y and that of
# index 0. SimpleITK, which it calls, has the order x, y, z. load_slice() and the scales of mhdview leave out the same index.
# Seen: an image of 5 x 4 x 3 voxels with the spacing 0.1, 0.2 and 0.5 mm has 5 sagittal slices 0.2 mm apart, 0.8 mm in all
# rather than 0.4, and 4 coronal ones 0.1 mm apart. Axial slices are right, and so is everything where x and y agree.
# Fix: spacing and origin of load_data(), with the index 0 for sagittal and 1 for coronal slices.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps mhdtools==1.0.1 SimpleITK==2.5.7 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
import SimpleITK
from mhdtools import common

shape, spacing, origin = (5, 4, 3), (0.1, 0.2, 0.5), (10.0, 20.0, 30.0)
x, y, z = np.meshgrid(*map(np.arange, shape), indexing="ij")
image = SimpleITK.GetImageFromArray((100 * x + 10 * y + z).transpose(2, 1, 0).astype(np.int16))
image.SetSpacing(spacing)
image.SetOrigin(origin)
SimpleITK.WriteImage(image, "labels.mhd")
print("mhdtools", importlib.metadata.version("mhdtools"), "image of", shape, "spacing", spacing)
for plane, axis, index in (("axial", 2, 2), ("sagittal", 0, 1), ("coronal", 1, 0)):
    slices, start, step = common.load("labels.mhd", plane)
    where = [np.unique(part // 10 ** (2 - axis) % 10).tolist() for part in slices]
    print(f"  {plane}: {len(slices)} slices along {'xyz'[axis]}, {step} mm apart from {start} mm on, right: {spacing[axis]} mm")
    assert where == [[i] for i in range(shape[axis])]
    assert (step, start) == (spacing[index], origin[index])
    flat, _, steps = common.load_slice("labels.mhd", plane, 0)
    assert list(steps) == [s for i, s in enumerate(spacing) if i != index]
PYTHON
