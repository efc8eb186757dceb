# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The joint state broadcaster: samples the states of all joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.broadcasters import JointStateBroadcasterParameters
from armsim_ros.control.broadcaster import Broadcaster
from armsim_ros.errors import ControllerError
from armsim_ros.model.robot_model import JointType

InterfaceValues = tuple[str, tuple[str, ...], tuple[float, ...]]

QUANTITIES = ('position', 'velocity', 'effort')


@dataclass(frozen=True, slots=True, eq=False)
class JointStateLayout:
    """
    Which published value is where in a sample's values.

    :param names: (n,) joints of ``joint_states``.
    :param slots: (3, n) of position, velocity and effort.
    :param dynamic: owner, its interfaces, their slots, for ``dynamic_joint_states``.
    """

    names: tuple[str, ...]
    slots: NDArray[np.intp]
    dynamic: tuple[tuple[str, tuple[str, ...], tuple[int, ...]], ...]


@dataclass(frozen=True, slots=True, eq=False)
class JointStateSnapshot:
    """
    Content of ``joint_states`` at a time; NaN where a joint has no such interface.

    :param frame_id: of the message's header.
    :param values: (m,) in the order of the layout's slots.
    """

    time_ns: int
    frame_id: str
    layout: JointStateLayout
    values: Vector

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
    def dynamic(self) -> tuple[InterfaceValues, ...]:
        """(Joint, interface names, values) of each joint, sensor and gpio."""
        values = self.values.tolist()
        return tuple(
            (owner, kinds, tuple([values[slot] for slot in slots]))
            for owner, kinds, slots in self.layout.dynamic)

    def _quantity(self, row: int) -> Vector:
        return np.asarray(self.values[self.layout.slots[row]])


class _Slots:
    """Gives each interface of each owner a place among a sample's values."""

    def __init__(self) -> None:
        #: Owner -> interface as it is published -> slot.
        self.owners: dict[str, dict[str, int]] = {}
        #: Values that are not measured; the last is that of interfaces that do not exist.
        self.template: list[float] = []

    def add(self, owner: str, kind: str, value: float = np.nan) -> int:
        """Return the slot of an interface; the value is that while nothing is measured."""
        kinds = self.owners.setdefault(owner, {})
        if kind not in kinds:
            kinds[kind] = len(self.template)
            self.template.append(value)
        return kinds[kind]

    def layout(self, names: Sequence[str]) -> JointStateLayout:
        """Return the layout for some joints."""
        nothing = len(self.template)
        self.template.append(np.nan)
        slots = [[self.owners[name].get(kind, nothing) for name in names] for kind in QUANTITIES]
        dynamic = tuple(
            (owner, tuple(kinds), tuple(kinds.values())) for owner, kinds in self.owners.items())
        table = np.array(slots, dtype=np.intp).reshape(len(QUANTITIES), len(names))
        return JointStateLayout(tuple(names), table, dynamic)


class JointStateBroadcaster(Broadcaster[JointStateBroadcasterParameters, JointStateSnapshot]):
    """
    Samples the states of all joints, or of those that are asked for.

    With the URDF's filter the joints come in alphabetical order, else in that of the state
    interfaces; extra joints come last.
    """

    parameters_class: ClassVar[type[Settings]] = JointStateBroadcasterParameters

    def on_init(self) -> None:
        """Know whether joints and interfaces are restricted."""
        super().on_init()
        self._restricted = bool(self.parameters.joints and self.parameters.interfaces)

    @property
    def publish_rate(self) -> float:
        """Samples a second [Hz]."""
        return self.parameters.publish_rate

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """Every interface that is read; those asked for by parameter must exist."""
        if self._restricted:
            kinds = self.parameters.interfaces
            return tuple(f'{joint}/{kind}' for joint in self.parameters.joints for kind in kinds)
        hardware = self.context.hardware
        of_joints = (
            f'{joint}/{kind}'
            for joint in hardware.joint_names
            for kind in hardware.state_interfaces.get(joint, ()))
        # What controllers export, as controller/joint/interface, comes and goes with them.
        others = (name for name in hardware.other_states if name.count('/') == 1)
        return (*of_joints, *others)

    @property
    def reads_all_states(self) -> bool:
        """Whether no parameter restricts what is published."""
        return not self._restricted

    def configure(self) -> None:
        """Report parameters that have no effect."""
        parameters = self.parameters
        mapped = parameters.map_interface_to_joint_state
        if bool(parameters.joints) != bool(parameters.interfaces):
            self._warn('joints and interfaces restrict only together; everything is published')
        for quantity in QUANTITIES if self._restricted else ():
            source = getattr(mapped, quantity)
            if quantity in parameters.interfaces and source != quantity:
                self._warn(
                    f"map_interface_to_joint_state.{quantity} '{source}' has no effect: "
                    f"'{quantity}' itself is among interfaces")
        if not parameters.frame_id:
            self._warn('frame_id is empty')

    def activate(self, time_ns: int) -> None:
        """Find out where the values come from."""
        super().activate(time_ns)
        hardware, renamed, slots = self.context.hardware, self._renamed(), _Slots()
        measured: dict[str, tuple[list[int], list[int]]] = {}
        self._others: list[tuple[str, int]] = []
        names: dict[str, None] = {}
        for interface in self.required_state_interfaces:
            owner, _, kind = interface.rpartition('/')
            published = renamed.get(kind, kind)
            slot = slots.add(owner, published)
            if hardware.motion_of(interface):
                places, filled = measured.setdefault(kind, ([], []))
                places.append(hardware.index[owner])
                filled.append(slot)
            else:
                self._others.append((interface, slot))
            if published in QUANTITIES:
                names[owner] = None
        if not slots.owners:
            raise ControllerError(f"'{self.name}': there are no state interfaces to publish")
        order = self._filtered(list(names))
        for extra in self.parameters.extra_joints:
            if extra.name not in slots.owners:
                order.append(extra.name)
                for quantity in QUANTITIES:
                    slots.add(extra.name, quantity, getattr(extra, quantity))
        self._layout = slots.layout(order)
        self._template = np.array(slots.template)
        # A mapped interface is written last: it overrides the standard interface.
        last = sorted(measured.items(), key=lambda item: renamed.get(item[0], item[0]) != item[0])
        self._measured = [
            (hardware.state.of(kind), np.array(places), np.array(filled))
            for kind, (places, filled) in last]
        if not self.parameters.publish_dynamic_joint_states:
            used = set(self._layout.slots.ravel().tolist())
            self._others = [entry for entry in self._others if entry[1] in used]

    def read(self, time_ns: int) -> JointStateSnapshot:
        """Return the states of now [ns]."""
        values = self._template.copy()
        for state, places, filled in self._measured:
            values[filled] = state[places]
        if self._others:
            states = self.context.hardware.other_states
            for interface, slot in self._others:
                values[slot] = states.get(interface, np.nan)
        return JointStateSnapshot(time_ns, self.parameters.frame_id, self._layout, values)

    def _renamed(self) -> dict[str, str]:
        """Return interface of the hardware -> interface as which it is published."""
        found = {}
        for quantity in QUANTITIES:
            asked_for = self._restricted and quantity in self.parameters.interfaces
            source = getattr(self.parameters.map_interface_to_joint_state, quantity)
            found[quantity if asked_for else source] = quantity
        return found

    def _filtered(self, names: list[str]) -> list[str]:
        """Return the movable joints of the URDF among the names, where they are filtered."""
        model = self.context.model
        if self._restricted or model is None or not self.parameters.use_urdf_to_filter:
            return names
        joints = (model.joints.get(name) for name in names)
        return sorted(j.name for j in joints if j is not None and j.type is not JointType.FIXED)

    def _warn(self, text: str) -> None:
        self.events.warn(self.time_ns, text)
