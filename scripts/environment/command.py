# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The command line of env.py."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import fcntl
import os
from pathlib import Path
import sys

from environment.failure import SetupError
from environment.stages import EnvironmentBuilder

ROOT = Path(__file__).resolve().parent.parent.parent


def run(argv: Sequence[str]) -> int:
    """
    Make or complete the environment.

    :returns: 0, or 1 after one message that says what is missing.
    """
    parser = argparse.ArgumentParser(prog='env.py',
                                     description='Make or complete the environment.')
    parser.add_argument('--venv', type=Path, default=ROOT / '.venv',
                        help='the environment (default: .venv in the source tree)')
    parser.add_argument('--with', dest='extras', action='append', default=[], metavar='EXTRA',
                        help='an extra of setup.cfg to install as well: test, lint')
    parser.add_argument('--this-python', action='store_true',
                        help='make the environment anew where it has another Python than this')
    arguments = parser.parse_args(argv)
    folder = os.open(ROOT, os.O_RDONLY)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX)
        EnvironmentBuilder(ROOT, arguments.venv.absolute()).build(
            arguments.extras, this_python=arguments.this_python)
    except SetupError as failure:
        print(f'env: {failure}', file=sys.stderr)
        return 1
    except OSError as error:
        print(f'env: cannot write {error.filename or arguments.venv}: {error.strerror}; make the '
              'folder writable, or choose others with VENV=DIR and XDG_CACHE_HOME=DIR',
              file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print('env: interrupted; the next run goes on from here', file=sys.stderr)
        return 130
    finally:
        os.close(folder)
    return 0
