# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Makes the Python environment that the Makefile's targets run in; standard library only.

A second run compares content hashes, finds nothing to do, and returns at once. This file is
written so that a Python that is too old can read it and say so.
"""

import sys

OLDEST, NEWEST = (3, 10), (3, 13)


def main():
    # type: () -> int
    """Make or complete the environment; returns the exit status."""
    if not OLDEST <= sys.version_info[:2] <= NEWEST:
        sys.stderr.write(
            'env: Python {}.{} is installed as {}, but armsim_ros needs 3.{} to 3.{}; '
            'name another one: make PYTHON=python3.12 ...\n'.format(
                sys.version_info[0], sys.version_info[1], sys.executable, OLDEST[1], NEWEST[1]))
        return 1
    from environment.stages import run
    return run(sys.argv[1:])


if __name__ == '__main__':
    sys.exit(main())
