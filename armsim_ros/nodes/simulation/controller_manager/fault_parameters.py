# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters ``faults.<joint>.{lag, bias, blocked}`` of the controller manager."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node

from armsim_ros.config.simulation import JointFault, JointFaults
from armsim_ros.control.faults import FaultInjector
from armsim_ros.nodes.parameters import SettingsParameters


class FaultParameters:
    """
    Injects joint faults; only if ``fault_injection`` of simulation.yaml is set.

    :param node: the manager's node.
    :param injector: makes the joints fail.
    :param joints: those of the manager's robot.
    """

    def __init__(self, node: Node, injector: FaultInjector, joints: Sequence[str]) -> None:
        """Declare the parameters of every joint that can be commanded, without faults."""
        self._node = node
        self._injector = injector
        self._shown = JointFaults(faults={name: JointFault() for name in joints})
        SettingsParameters(node, self._shown, self._changed)
        node.get_logger().warning('faults of joints can be injected by the parameters faults.*')

    def _changed(self, settings: JointFaults) -> None:
        for joint, fault in settings.faults.items():
            if fault != self._shown.faults[joint]:
                self._injector.set_fault(joint, fault)
                self._node.get_logger().warning(f"fault of joint '{joint}': {fault}")
        self._shown = settings
