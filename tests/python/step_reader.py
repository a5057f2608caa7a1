"""Prints the solids of a STEP file, read by gmsh: `python step_reader.py FILE`.

A program of its own: OpenCASCADE gives a process other signal handlers, after which a broken pipe ends it without a word.
"""

import json
import sys

import gmsh


def main(path: str) -> None:
    """Print volume and colour of every solid by name, and the number of surfaces, as JSON."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Geometry.OCCImportLabels", 1)
    solids = gmsh.model.occ.importShapes(path, highestDimOnly=True)
    gmsh.model.occ.synchronize()
    volumes = {}
    for dim, tag in solids:
        assert dim == 3, "a solid"
        name = gmsh.model.getEntityName(dim, tag).rsplit("/", 1)[-1]
        volumes[name] = (gmsh.model.occ.getMass(dim, tag), gmsh.model.getColor(dim, tag)[:3])
    json.dump([volumes, len(gmsh.model.getEntities(2))], sys.stdout)
    gmsh.finalize()


if __name__ == "__main__":
    main(sys.argv[1])
