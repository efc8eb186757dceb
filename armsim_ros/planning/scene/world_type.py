# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How objects of a simulated world are marked in messages."""

WORLD_TYPE = 'armsim_ros/world'
"""
Key of their object type, whose ``db`` is the world's epoch.

In the scene they have no type, so that who sends them back is known for a user.
"""
