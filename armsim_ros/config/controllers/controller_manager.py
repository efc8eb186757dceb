# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the controller manager, as ros2_control declares them."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, field_validator

from armsim_ros.config.base import KeyedSettings, parameter, Settings, unique_names


class ControllerEntry(Settings):
    """What the manager has to know of a controller before it can load it."""

    type: str = parameter(..., 'class of the controller', min_length=1)
    params_file: tuple[str, ...] = parameter((), "files with the controller's parameters")
    fallback_controllers: tuple[str, ...] = parameter(
        (), 'controllers to activate when this one fails'
    )
    node_options_args: tuple[str, ...] = parameter(
        (), "ROS arguments of the controller's node: remappings and parameters"
    )

    @field_validator('params_file', mode='before')
    @classmethod
    def _one_or_many(cls, value: Any) -> Any:
        return (value,) if isinstance(value, str) else value


class InitialHardwareState(Settings):
    """In which state hardware components start; the others become active."""

    unconfigured: tuple[str, ...] = parameter((), 'components left unconfigured', read_only=True)
    inactive: tuple[str, ...] = parameter((), 'components left inactive', read_only=True)
    shutdown_on_initial_state_failure: bool = parameter(
        True, 'has no effect: simulated hardware reaches every state', read_only=True
    )

    _unique = field_validator('unconfigured', 'inactive')(unique_names)


class SwitchDefaults(Settings):
    """What a switch request means that leaves its strictness open."""

    strictness: Literal['best_effort', 'strict'] = parameter(
        'best_effort', 'strictness of a request that names none', read_only=True
    )


class ManagerDefaults(Settings):
    """Defaults of requests."""

    switch_controller: SwitchDefaults = parameter(SwitchDefaults(), 'switch requests')
    allow_controller_activation_with_inactive_hardware: bool = parameter(
        False, 'whether controllers of inactive hardware can be activated', read_only=True
    )
    deactivate_controllers_on_hardware_self_deactivate: bool = parameter(
        True, 'has no effect: simulated hardware does not deactivate itself', read_only=True
    )


class ControllerManagerParameters(KeyedSettings):
    """Parameters of ``controller_manager``; besides its own keys one block a controller."""

    is_no = "parameter of the manager, and no controller's block with a type"
    __pydantic_extra__: dict[str, ControllerEntry] = Field(init=False)

    update_rate: int = parameter(
        100, 'updates of the controllers a second [Hz]', read_only=True, ge=1
    )
    enforce_command_limits: bool = parameter(
        False, "keep commands within the URDF's limits", read_only=True
    )
    hardware_components_initial_state: InitialHardwareState = parameter(
        InitialHardwareState(), 'hardware that does not start active', read_only=True
    )
    defaults: ManagerDefaults = parameter(ManagerDefaults(), 'defaults of requests')

    @property
    def controllers(self) -> dict[str, ControllerEntry]:
        """Controller -> its block."""
        return self.__pydantic_extra__
