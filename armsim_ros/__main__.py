# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Run a program of the package: ``python -m armsim_ros bringup``."""

import sys

if not getattr(sys.flags, 'safe_path', False):
    # The working folder, which may hold a numpy.py of the user's, is looked into last.
    sys.path.append(sys.path.pop(0))

from armsim_ros.cli.main import main

sys.exit(main())
