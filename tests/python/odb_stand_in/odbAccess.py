"""A stand-in for Abaqus' own module: it "opens" a JSON file that has the shape of an output database."""

import json


class _Output:
    def __init__(self, data):
        self.data = tuple((time, value) for time, value in data)


class _Region:
    def __init__(self, outputs):
        self.historyOutputs = {name: _Output(data) for name, data in outputs.items()}


class _Step:
    def __init__(self, regions):
        self.historyRegions = {name: _Region(outputs) for name, outputs in regions.items()}


class _Odb:
    def __init__(self, steps):
        self.steps = {name: _Step(regions) for name, regions in steps.items()}
        self.closed = False

    def close(self):
        """As the real one has it."""
        self.closed = True


def openOdb(path, readOnly=False):  # noqa: N802, N803 - Abaqus' names
    """Open a stand-in database."""
    assert readOnly, "results are only read"
    with open(path) as file:
        return _Odb(json.load(file))
