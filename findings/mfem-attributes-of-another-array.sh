#!/usr/bin/env bash
# PyMFEM 4.10.0.1: a .vtu whose active array of cells is "attribute" gives them the numbers of the first array in the file.
# Without that word (Scalars of CellData) all cells have attribute 1. Neither way has a message.
# Seen: with quality 5 and 5 before attribute 3 and 7, the cells have 5 and 5. PyVista keeps the order in which arrays were set.
# Mends it: "attribute" as the first or only array of the cells.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile mfem==4.10.0.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import mfem.ser as mfem


def array(name, kind, values, more=""):
    return f'<DataArray type="{kind}" Name="{name}"{more} format="ascii">\n{values}\n</DataArray>\n'


own, other = array("attribute", "Int32", "3 7"), array("quality", "Int32", "5 5")


def attributes(active, arrays):
    with open("two.vtu", "w") as file:
        file.write(
            '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
            'header_type="UInt32">\n<UnstructuredGrid>\n<Piece NumberOfPoints="5" NumberOfCells="2">\n'
            f'<CellData Scalars="{active}">\n' + "".join(arrays) + "</CellData>\n<Points>\n"
            + array("Points", "Float64", "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1", ' NumberOfComponents="3"')
            + "</Points>\n<Cells>\n"
            + array("connectivity", "Int64", "0 1 2 3 1 4 2 3")
            + array("offsets", "Int64", "4 8")
            + array("types", "UInt8", "10 10")
            + "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
        )
    mesh = mfem.Mesh("two.vtu", 1, 0)
    return [mesh.GetAttribute(i) for i in range(mesh.GetNE())]


seen = {
    "first": attributes("attribute", [own, other]),
    "second": attributes("attribute", [other, own]),
    "second, not active": attributes("quality", [other, own]),
}
print("mfem", importlib.metadata.version("mfem"), "attributes of two cells by the place of their array:", seen)
assert seen == {"first": [3, 7], "second": [5, 5], "second, not active": [1, 1]}
PYTHON
