# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics and service of a PID controller: references, measured states, controller state."""

from __future__ import annotations

from typing import Any

from control_msgs.msg import MultiDOFCommand, MultiDOFStateStamped, SingleDOFState
from rclpy.node import Node
from std_srvs.srv import SetBool

from armsim_ros.control.command_controllers.pid_controller import PidController
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.simulation.wanted_publisher import WantedPublisher


class PidTopics:
    """
    Passes references to the controller and publishes its state.

    :param node: the controller's node.
    """

    def __init__(self, node: Node, controller: PidController) -> None:
        self._controller = controller
        self._publisher = WantedPublisher(
            node, MultiDOFStateStamped, '~/controller_state', qos.STATE)
        self._published_ns = -1
        self._inputs: list[Any] = [
            node.create_subscription(MultiDOFCommand, '~/reference', self._refer, qos.COMMAND),
            node.create_service(SetBool, '~/set_feedforward_control', self._set_feedforward,
                                qos_profile=qos.SERVICES),
        ]
        if controller.parameters.use_external_measured_states:
            self._inputs.append(node.create_subscription(
                MultiDOFCommand, '~/measured_state', self._measure, qos.COMMAND))

    def publish(self, time_ns: int) -> None:
        """Publish the latest state, if it is new [ns]."""
        snapshot = self._controller.snapshot()
        if snapshot is None or not self._publisher.wanted(time_ns):
            return
        if snapshot.time_ns == self._published_ns:
            return
        self._published_ns = snapshot.time_ns
        message = MultiDOFStateStamped(dof_states=[
            SingleDOFState(
                name=name,
                reference=float(snapshot.reference[0, i]),
                feedback=float(snapshot.feedback[0, i]),
                feedback_dot=float(snapshot.feedback[1, i]) if len(snapshot.feedback) > 1 else 0.0,
                error=float(snapshot.error[0, i]),
                error_dot=float(snapshot.error[1, i]),
                time_step=snapshot.period,
                output=float(snapshot.output[i]),
            )
            for i, name in enumerate(snapshot.names)
        ])
        fill_time(message.header.stamp, snapshot.time_ns)
        self._publisher.publish(message, time_ns)

    def _refer(self, message: MultiDOFCommand) -> None:
        self._controller.receive(message.dof_names, message.values, message.values_dot)

    def _measure(self, message: MultiDOFCommand) -> None:
        self._controller.measure(message.dof_names, message.values, message.values_dot)

    def _set_feedforward(self, request: Any, response: Any) -> Any:
        self._controller.set_feedforward(request.data)
        response.success = True
        response.message = f'feed-forward is {"on" if request.data else "off"}'
        return response
