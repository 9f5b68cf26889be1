"""``python -m lrsr`` is the same as ``lrsr``."""

import sys

from lrsr.cli import main

if __name__ == "__main__":
    sys.exit(main())
