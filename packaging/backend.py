"""The build backend of pip: maturin's, once cargo is found.

Without cargo maturin's own backend downloads Rust and compiles for minutes, and pip prints nothing meanwhile.
"""

import shutil
import sys

from maturin import *  # noqa: F403

MISSING = """\
mesocrete is built from source here, which needs Rust 1.89 or later, and there is no `cargo` on the PATH.
 - Without a compiler: download a wheel (site/pages/install.md says where), then pip install ./mesocrete-...-abi3-....whl
 - With one: get Rust from https://rustup.rs, open a new shell, and run the same pip command again.
"""

if shutil.which("cargo") is None:
    sys.exit(MISSING)
