# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The joint state broadcaster: samples the states of all joints."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np

from armsim_ros.arrays import selector, Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.joint_state_broadcaster import JointStateBroadcasterParameters
from armsim_ros.control.broadcasters.broadcaster import Broadcaster
from armsim_ros.control.controller import ControllerContext
from armsim_ros.control.hardware_interface import COMMAND_INTERFACES

InterfaceValues = tuple[str, tuple[str, ...], tuple[float, ...]]

QUANTITIES = ('position', 'velocity', 'effort')


@dataclass(frozen=True, slots=True, eq=False)
class JointStateSnapshot:
    """
    Content of ``joint_states`` at one time; NaN where a joint has no such interface.

    :param position: (n,) [rad or m].
    :param velocity: (n,) [rad/s or m/s].
    :param effort: (n,) [N*m or N].
    :param interfaces: makes the content of ``dynamic``; None where that is not published.
    """

    time_ns: int
    frame_id: str
    names: tuple[str, ...]
    position: Vector
    velocity: Vector
    effort: Vector
    interfaces: Callable[[], tuple[InterfaceValues, ...]] | None = None

    @property
    def dynamic(self) -> tuple[InterfaceValues, ...] | None:
        """
        Return (joint, interface names, values) of each joint.

        That is the content of ``dynamic_joint_states``; None where it is not published.
        """
        return self.interfaces() if self.interfaces is not None else None


class JointStateBroadcaster(Broadcaster[JointStateBroadcasterParameters, JointStateSnapshot]):
    """
    Samples the states of all joints, or of those that are asked for.

    Joints come in the order of the parameter, else in the hardware's; extra joints come last.
    """

    parameters_class: ClassVar[type[Settings]] = JointStateBroadcasterParameters

    def __init__(
        self,
        name: str,
        type: str,  # noqa: A002
        parameters: JointStateBroadcasterParameters,
        context: ControllerContext,
    ) -> None:
        """Start unconfigured, see :class:`Controller`."""
        super().__init__(name, type, parameters, context)
        self._restricted = bool(parameters.joints and parameters.interfaces)
        self._hardware_joints = self._published()
        extra = tuple(joint.name for joint in parameters.extra_joints)
        self.joint_names = self._hardware_joints + extra
        self._gather: list[tuple[int, Vector, Any, Any]] = []
        self._template = np.empty((3, 0))
        self._measured: tuple[tuple[str, tuple[str, ...], int], ...] = ()
        self._extra: tuple[InterfaceValues, ...] = ()

    @property
    def joints(self) -> tuple[str, ...]:
        """All joints that are published."""
        return self.joint_names

    @property
    def publish_rate(self) -> float:
        """Samples a second [Hz]."""
        return self.parameters.publish_rate

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """Every interface that is read; those asked for by parameter must exist."""
        return tuple(
            f'{joint}/{kind}' for joint in self._hardware_joints for kind in self._kinds(joint)
        )

    def configure(self) -> None:
        """Find out where the values come from."""
        parameters = self.parameters
        if bool(parameters.joints) != bool(parameters.interfaces):
            text = 'joints and interfaces restrict only together; everything is published'
            self.events.add(self.time_ns, 'warning', 'warning', text)
        hardware = self.context.hardware
        names = self.joint_names
        self._template = np.full((3, len(names)), np.nan)
        for extra in parameters.extra_joints:
            values = (extra.position, extra.velocity, extra.effort)
            self._template[:, names.index(extra.name)] = values
        self._measured = tuple(
            (joint, self._kinds(joint), hardware.index[joint])
            for joint in self._hardware_joints if joint in hardware.index
        )
        self._extra = tuple(
            (extra.name, QUANTITIES, (extra.position, extra.velocity, extra.effort))
            for extra in parameters.extra_joints
        )
        self._gather = []
        for row, quantity in enumerate(QUANTITIES):
            kind = getattr(parameters.map_interface_to_joint_state, quantity)
            # Joints that the hardware lacks are told of at activation, like missing interfaces.
            having = [
                j for j in self._hardware_joints if j in hardware.index and kind in self._kinds(j)
            ]
            if having and kind in COMMAND_INTERFACES:
                columns = selector([names.index(j) for j in having])
                source = selector([hardware.index[j] for j in having])
                self._gather.append((row, hardware.state.of(kind), source, columns))

    def read(self, time_ns: int) -> JointStateSnapshot:
        """Return the states of now [ns]."""
        values = self._template.copy()
        for row, state, source, columns in self._gather:
            values[row, columns] = state[source]
        interfaces = None
        if self.parameters.publish_dynamic_joint_states:
            hardware = self.context.hardware
            # Only who listens to them has them sorted.
            states = tuple([hardware.state.of(kind).copy() for kind in COMMAND_INTERFACES])
            others = {} if self._restricted else hardware.other_states
            interfaces = partial(_interface_values, self._measured, self._extra, states, others)
        frame = self.parameters.frame_id
        return JointStateSnapshot(
            time_ns, frame, self.joint_names, values[0], values[1], values[2], interfaces
        )

    def _published(self) -> tuple[str, ...]:
        hardware, model = self.context.hardware, self.context.model
        if self._restricted:
            return self.parameters.joints
        names = tuple(j for j in hardware.joint_names if hardware.state_interfaces.get(j))
        if model is None or not self.parameters.use_urdf_to_filter:
            return names
        return tuple(j for j in names if j in model.joints)

    def _kinds(self, joint: str) -> tuple[str, ...]:
        if self._restricted:
            return self.parameters.interfaces
        return self.context.hardware.state_interfaces.get(joint, ())


def _interface_values(
    measured: Sequence[tuple[str, tuple[str, ...], int]],
    extra: tuple[InterfaceValues, ...],
    states: Sequence[Vector],
    others: Mapping[str, float],
) -> tuple[InterfaceValues, ...]:
    """
    Return what ``dynamic_joint_states`` says.

    :param measured: joint, its interfaces, its place in the states.
    :param extra: joints that the hardware does not have.
    :param states: (n,) of each interface.
    :param others: interface of a sensor or gpio -> its value.
    """
    values = {kind: state.tolist() for kind, state in zip(COMMAND_INTERFACES, states, strict=True)}
    owners: dict[str, dict[str, float]] = {}
    for name, value in others.items():
        owner, _, kind = name.rpartition('/')
        owners.setdefault(owner, {})[kind] = value
    return (
        *((joint, kinds, tuple([values[kind][place] for kind in kinds]))
          for joint, kinds, place in measured),
        *((owner, tuple(kinds), tuple(kinds.values())) for owner, kinds in owners.items()),
        *extra,
    )  # fmt: skip
