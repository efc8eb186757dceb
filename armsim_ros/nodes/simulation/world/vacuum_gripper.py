# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services ``<ns>/<gripper>/on`` and ``off``, and the topic ``grasping``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from std_msgs.msg import Bool
from std_srvs.srv import Empty

from armsim_ros.errors import SimulationError
from armsim_ros.nodes import qos
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.world.work import Work
from armsim_ros.sim.grippers.vacuum_gripper import VacuumControl, VacuumGripper

#: Wall time between two messages about whether something is held [s].
_PERIOD = 0.1


class VacuumGripperServer:
    """
    Switches a suction cup and publishes whether it holds something.

    :param node: the node that serves.
    :param work: reaches the loop.
    :param namespace: of the robot, with a slash before it.
    :param tell_scene: publishes the present world to planning, and then calls back.
    """

    def __init__(
        self,
        node: Node,
        work: Work,
        dispatcher: Dispatcher,
        namespace: str,
        gripper: VacuumGripper,
        tell_scene: Callable[[Callable[[], object]], object],
    ) -> None:
        self._node = node
        self._work = work
        self._gripper = gripper
        self._control = VacuumControl(
            work.loop, gripper, lambda: dispatcher.post(lambda: tell_scene(self._notice)))
        # In a cell the name begins with the namespace.
        own = gripper.name.removeprefix(f'{namespace.strip("/")}/')
        place = f'{namespace}/{own}'
        group = ReentrantCallbackGroup()
        for name, answer in (('on', self._on), ('off', self._off)):
            node.create_service(Empty, f'{place}/{name}', answer, callback_group=group)
        self._publisher = node.create_publisher(Bool, f'{place}/grasping', qos.LATCHED)
        self._grasping = False
        self._publish()
        dispatcher.every(_PERIOD, self._look)

    async def _on(self, _: Any, response: Any) -> Any:
        await self._switched(self._control.on)
        return response

    async def _off(self, _: Any, response: Any) -> Any:
        await self._switched(self._control.off)
        return response

    async def _switched(self, switch: Any) -> None:
        try:
            await self._work.in_loop(switch)
        except SimulationError as error:
            self._node.get_logger().error(f"gripper '{self._gripper.name}': {error}")

    def _look(self) -> None:
        while self._gripper.losses:
            self._node.get_logger().warning(self._gripper.losses.popleft())
        if self._publisher.get_subscription_count():
            self._publish()

    def _notice(self) -> None:
        self._grasping = bool(self._gripper.held)
        self._publish()

    def _publish(self) -> None:
        self._publisher.publish(Bool(data=self._grasping))
