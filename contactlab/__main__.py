"""`python -m contactlab`, the same as the command `contactlab`."""

import sys

from contactlab.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
