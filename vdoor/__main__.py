"""`python -m vdoor`, the same as the command `vdoor`: for a Python whose scripts are not on the path.

An example: ``python -m vdoor run map.yaml --out result/``.
"""

from vdoor.cli import main

if __name__ == "__main__":
    main()
