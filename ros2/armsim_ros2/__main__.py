# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``python -m armsim_ros2``: the ``ros2`` command."""

from armsim_ros2.main import main

if __name__ == '__main__':
    main()
