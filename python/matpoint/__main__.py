"""`python -m matpoint`: the program matpoint, with the same words."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def main() -> None:
    """Becomes the program that was installed with the package; comes back only with an error."""
    program = Path(__file__).parent / "bin" / "matpoint"
    os.environ.setdefault("MATPOINT_PYTHON", sys.executable)
    try:
        os.execv(program, ["matpoint", *sys.argv[1:]])
    except OSError as error:
        print(f'error: cannot start the program "{program}": {error}', file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
