"""The command `vdoor`, also as `python -m vdoor`: for a Python whose scripts are not on the path.

An example: ``python -m vdoor run map.yaml --out result/``.
"""

import os
import signal
import sys
from types import FrameType

STREAMS = 3


def main() -> None:
    """Run the command; Ctrl-C ends it with exit code 130 and without a traceback, whenever it comes."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # while modules are imported
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy would start a thread for each core, for nothing
    for number in range(STREAMS):
        _keep_open(number)
    from vdoor.cli import main as command  # noqa: PLC0415  # takes a moment

    signal.signal(signal.SIGINT, _stop)
    try:
        command()
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # while the process ends


def _keep_open(number: int) -> None:
    """Open a standard stream that is closed, so that no output file gets its number and what is written to it."""
    try:
        os.fstat(number)
    except OSError:
        os.open(os.devnull, os.O_RDWR)


def _stop(number: int, _: FrameType | None) -> None:
    sys.exit(128 + number)


if __name__ == "__main__":
    main()
