"""The ``mesocrete`` command: the same code as the Rust binary."""

import sys

from ._mesocrete import _run_command


def main() -> int:
    """Run the command line in ``sys.argv`` and return its exit code."""
    code: int = _run_command(["mesocrete", *sys.argv[1:]])
    return code


if __name__ == "__main__":
    sys.exit(main())
