# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Run a program of the package: ``python -m armsim_ros bringup``."""

import sys

from armsim_ros.cli.main import main

sys.exit(main())
