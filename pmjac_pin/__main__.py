"""``python -m pmjac_pin`` is the same as ``pmjac``."""

import sys

from pmjac_pin.cli import main

if __name__ == "__main__":
    sys.exit(main())
