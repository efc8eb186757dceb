# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controller manager's state, as ``controller_manager_msgs`` and ``lifecycle_msgs``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from controller_manager_msgs.msg import (
    ChainConnection,
    ControllerManagerActivity,
    ControllerState,
    HardwareComponentState,
    HardwareInterface,
    NamedLifecycleState,
)
from lifecycle_msgs.msg import State

from armsim_ros.nodes.conversions.time import fill_time

if TYPE_CHECKING:  # a spawner starts in half the time without all of control
    from armsim_ros.control.manager.manager_info import ControllerInfo, InterfaceInfo
    from armsim_ros.control.manager.resources import HardwareComponentInfo

STATE_IDS = {
    'unknown': State.PRIMARY_STATE_UNKNOWN,
    'unconfigured': State.PRIMARY_STATE_UNCONFIGURED,
    'inactive': State.PRIMARY_STATE_INACTIVE,
    'active': State.PRIMARY_STATE_ACTIVE,
    'finalized': State.PRIMARY_STATE_FINALIZED,
}
_LABELS = {number: label for label, number in STATE_IDS.items()}


def state_message(label: str) -> State:
    """Return the message of a state; an unknown state is ``unknown``."""
    return State(id=STATE_IDS.get(label, State.PRIMARY_STATE_UNKNOWN), label=label)


def state_label(message: State) -> str:
    """Return the name of a state: its number's, or where that is 0 its label."""
    return _LABELS.get(message.id, 'unknown') if message.id else message.label or 'unknown'


DATA_TYPE = 'double'


def controller_message(info: ControllerInfo) -> ControllerState:
    """Return the message of a controller."""
    return ControllerState(
        name=info.name,
        state=info.state,
        type=info.type,
        update_rate=round(info.update_rate),
        claimed_interfaces=list(info.claimed_interfaces),
        required_command_interfaces=list(info.required_command_interfaces),
        required_state_interfaces=list(info.required_state_interfaces),
        is_chainable=info.chainable,
        is_chained=info.chained,
        exported_state_interfaces=list(info.exported_states),
        reference_interfaces=list(info.references),
        chain_connections=[
            ChainConnection(name=name, reference_interfaces=list(references))
            for name, references in info.connections.items()])


def interface_messages(infos: Iterable[InterfaceInfo]) -> list[HardwareInterface]:
    """Return the messages of interfaces, in their order."""
    return [
        HardwareInterface(
            name=info.name, data_type=DATA_TYPE, is_available=info.is_available,
            is_claimed=info.is_claimed)
        for info in infos]


def component_message(info: HardwareComponentInfo, rate: float) -> HardwareComponentState:
    """
    Return the message of a hardware component.

    :param rate: [Hz] at which it is read and written.
    """
    return HardwareComponentState(
        name=info.name, type=info.type, rw_rate=round(rate), plugin_name=info.plugin_name,
        state=state_message(info.state),
        command_interfaces=interface_messages(info.command_interfaces),
        state_interfaces=interface_messages(info.state_interfaces))


def activity_message(
    time_ns: int, controllers: Iterable[ControllerInfo],
    components: Iterable[HardwareComponentInfo]
) -> ControllerManagerActivity:
    """Return the message of ``~/activity``."""
    message = ControllerManagerActivity(
        controllers=[
            NamedLifecycleState(name=info.name, state=state_message(info.state))
            for info in controllers],
        hardware_components=[
            NamedLifecycleState(name=info.name, state=state_message(info.state))
            for info in components])
    fill_time(message.header.stamp, time_ns)
    return message
