# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.core``: robot model, robot state, planning scene, trajectory."""


class World:
    """The world of a planning scene; empty, and filled through the scene."""
