"""A stand-in for lasso-python's reader of LS-DYNA's histories: JSON, by folders and names."""

import json


class Binout:
    """The histories of a file."""

    def __init__(self, path):
        with open(path) as file:
            self.content = json.load(file)

    def read(self, *path):
        """The array at a path."""
        found = self.content
        for name in path:
            found = found[name]
        return found
