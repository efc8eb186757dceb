# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The joint state broadcaster: samples the states of all joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from armsim_ros.arrays import Matrix, selector, Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.joint_state_broadcaster import JointStateBroadcasterParameters
from armsim_ros.control.broadcasters.broadcaster import Broadcaster
from armsim_ros.control.hardware_interface import COMMAND_INTERFACES

InterfaceValues = tuple[str, tuple[str, ...], tuple[float, ...]]

QUANTITIES = ('position', 'velocity', 'effort')


@dataclass(frozen=True, slots=True, eq=False)
class JointStateLayout:
    """
    How the content of ``joint_states`` is made of the states of the hardware.

    :param names: (n,) joints that are published.
    :param template: (3, n) position, velocity and effort that are not measured.
    :param gather: row of the template, its columns, interface's number, places in its states.
    :param measured: joint, its interfaces, its place in the states.
    :param extra: joints that the hardware does not have.
    """

    names: tuple[str, ...]
    template: Matrix
    gather: tuple[tuple[int, Any, int, Any], ...]
    measured: tuple[tuple[str, tuple[str, ...], int], ...]
    extra: tuple[InterfaceValues, ...]


#: That of a broadcaster that is not configured.
NOTHING = JointStateLayout((), np.empty((3, 0)), (), (), ())


@dataclass(frozen=True, slots=True, eq=False)
class JointStateSnapshot:
    """
    Content of ``joint_states`` at one time; NaN where a joint has no such interface.

    A sample is taken far more often than anybody looks at it: who looks has it sorted.

    :param frame_id: of the message's header.
    :param states: (m,) of each interface of the hardware.
    :param others: interface of a sensor or gpio -> its value; None where
        ``dynamic_joint_states`` is not published.
    """

    time_ns: int
    frame_id: str
    layout: JointStateLayout
    states: tuple[Vector, ...]
    others: Mapping[str, float] | None

    @property
    def names(self) -> tuple[str, ...]:
        """Joints that are published (n,)."""
        return self.layout.names

    @property
    def position(self) -> Vector:
        """Where the joints are (n,) [rad or m]."""
        return self._quantity(0)

    @property
    def velocity(self) -> Vector:
        """How fast they move (n,) [rad/s or m/s]."""
        return self._quantity(1)

    @property
    def effort(self) -> Vector:
        """What their drives give (n,) [N*m or N]."""
        return self._quantity(2)

    @property
    def dynamic(self) -> tuple[InterfaceValues, ...] | None:
        """
        Return (joint, interface names, values) of each joint.

        That is the content of ``dynamic_joint_states``; None where it is not published.
        """
        if self.others is None:
            return None
        values = {kind: state.tolist()
                  for kind, state in zip(COMMAND_INTERFACES, self.states, strict=True)}
        owners: dict[str, dict[str, float]] = {}
        for name, value in self.others.items():
            owner, _, kind = name.rpartition('/')
            owners.setdefault(owner, {})[kind] = value
        return (
            *((joint, kinds, tuple([values[kind][place] for kind in kinds]))
              for joint, kinds, place in self.layout.measured),
            *((owner, tuple(kinds), tuple(kinds.values())) for owner, kinds in owners.items()),
            *self.layout.extra,
        )  # fmt: skip

    def _quantity(self, row: int) -> Vector:
        values: Vector = self.layout.template[row].copy()
        for filled, columns, interface, source in self.layout.gather:
            if filled == row:
                values[columns] = self.states[interface][source]
        return values


class JointStateBroadcaster(Broadcaster[JointStateBroadcasterParameters, JointStateSnapshot]):
    """
    Samples the states of all joints, or of those that are asked for.

    Joints come in the order of the parameter, else in the hardware's; extra joints come last.
    """

    parameters_class: ClassVar[type[Settings]] = JointStateBroadcasterParameters

    def on_init(self) -> None:
        """Find out which joints are published."""
        super().on_init()
        self._restricted = bool(self.parameters.joints and self.parameters.interfaces)
        self._hardware_joints = self._published()
        extra = tuple(joint.name for joint in self.parameters.extra_joints)
        self.joint_names = self._hardware_joints + extra
        self._states: tuple[Vector, ...] = ()
        self._layout = NOTHING

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

    @property
    def reads_all_states(self) -> bool:
        """Whether no parameter restricts what is published."""
        return not self._restricted

    def configure(self) -> None:
        """Find out where the values come from."""
        parameters = self.parameters
        if bool(parameters.joints) != bool(parameters.interfaces):
            text = 'joints and interfaces restrict only together; everything is published'
            self.events.add(self.time_ns, 'warning', 'warning', text)
        hardware = self.context.hardware
        names = self.joint_names
        template = np.full((3, len(names)), np.nan)
        for extra in parameters.extra_joints:
            values = (extra.position, extra.velocity, extra.effort)
            template[:, names.index(extra.name)] = values
        gather = []
        for row, quantity in enumerate(QUANTITIES):
            kind = getattr(parameters.map_interface_to_joint_state, quantity)
            # Joints that the hardware lacks are told of at activation, like missing interfaces.
            having = [
                j for j in self._hardware_joints if j in hardware.index and kind in self._kinds(j)
            ]
            if having and kind in COMMAND_INTERFACES:
                columns = selector([names.index(j) for j in having])
                source = selector([hardware.index[j] for j in having])
                gather.append((row, columns, COMMAND_INTERFACES.index(kind), source))
        measured = tuple(
            (joint, self._kinds(joint), hardware.index[joint])
            for joint in self._hardware_joints if joint in hardware.index
        )
        given = tuple(
            (extra.name, QUANTITIES, (extra.position, extra.velocity, extra.effort))
            for extra in parameters.extra_joints
        )
        self._layout = JointStateLayout(names, template, tuple(gather), measured, given)
        self._states = tuple(hardware.state.of(kind) for kind in COMMAND_INTERFACES)

    def read(self, time_ns: int) -> JointStateSnapshot:
        """Return the states of now [ns]."""
        parameters, others = self.parameters, None
        if parameters.publish_dynamic_joint_states:
            others = {} if self._restricted else self.context.hardware.other_states
        states = tuple([state.copy() for state in self._states])
        return JointStateSnapshot(time_ns, parameters.frame_id, self._layout, states, others)

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
