# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What vendors' drivers offer to ROS beside controllers, over the state of the simulated arm."""

from armsim_ros.nodes.vendors.endpoints import ArmNodes, Endpoints, endpoints_of

__all__ = ['ArmNodes', 'Endpoints', 'endpoints_of']
