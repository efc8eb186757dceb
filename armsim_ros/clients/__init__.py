# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Clients of a running robot, or of upstream's stack: they use public ROS interfaces alone.

``RosClient`` is for programs: its calls return futures, and no call waits. ``ClientNode`` is for
tests and scripts: its calls wait with a time limit and assert that there is an answer. Both are a
node with a thread of its own, and send goals as ``GoalRun``. The facades put names to requests:
``MoveGroupClient``, ``TrajectoryClient`` of a controller, ``ControllerManagerClient``,
``ParameterClient`` of any node, ``SimulationClient``, ``StreamedArm`` for a policy; ``Stopper``
ends every motion. A name is imported when it is first asked for.
"""

from importlib import import_module
from typing import Any

#: Module -> its public names.
_LAZY = {
    'action_client': ('PatientActionClient',),
    'client_node': ('ClientNode', 'Collector', 'LATCHED'),
    'controller_manager': ('ControllerManagerClient', 'ParameterClient'),
    'motion': ('code_text', 'plan_goal', 'Stopper', 'SUCCESS'),
    'move_group': ('MoveGroupClient',),
    'node': ('GoalRun',),
    'ros_client': ('NotServedError', 'RosClient'),
    'simulation': ('SimulationClient',),
    'streamed_arm': ('StreamedArm',),
    'trajectory': ('trajectory_message', 'TrajectoryClient'),
}


def __getattr__(name: str) -> Any:
    for module, names in _LAZY.items():
        if name in names:
            return getattr(import_module(f'{__name__}.{module}'), name)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
