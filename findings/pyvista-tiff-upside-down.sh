#!/usr/bin/env bash
# PyVista 0.49.1: read() of a .tif stack turns each slice upside down. VTK's own reader, which it calls, does not.
# Seen: a stack of (6, 4, 5) comes as array[:, ::-1], so that labels of one model as .tif and .vti do not lie on each other.
# Mends it: get_reader("labels.tif"), then its reader.SetOrientationType(1) before read(); or array[:, ::-1].
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile pyvista==0.49.1 vtk==9.7.2 tifffile==2026.3.3 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
import pyvista
import tifffile
import vtk

labels = np.zeros((6, 4, 5), np.uint8)
labels[0, 0, 0], labels[5, 3, 1], labels[1, 0, 4] = 1, 2, 3
tifffile.imwrite("labels.tif", labels)
assert np.array_equal(tifffile.imread("labels.tif"), labels)


def array(grid):
    return np.asarray(grid.active_scalars).reshape(grid.dimensions[::-1])


plain = vtk.vtkTIFFReader()
plain.SetFileName("labels.tif")
plain.Update()
mended = pyvista.get_reader("labels.tif")
mended.reader.SetOrientationType(1)
seen = {"PyVista": pyvista.read("labels.tif"), "VTK": pyvista.wrap(plain.GetOutput()), "mended": mended.read()}
ways = {n: [np.array_equal(array(g), a) for a in (labels, labels[:, ::-1])] for n, g in seen.items()}
print("pyvista", pyvista.__version__, "vtk", vtk.VTK_VERSION, "as stored, upside down:", ways)
assert ways == {"PyVista": [False, True], "VTK": [True, False], "mended": [True, False]}
PYTHON
