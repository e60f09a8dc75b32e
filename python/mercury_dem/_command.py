"""The program `mercury-solve` that comes with the package."""

import signal
import sys

from ._mercury_dem import command


def main():
    # Ctrl-C is the program's: Python would raise an exception besides.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(command(sys.argv))
