# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the controller manager, as ros2_control declares them."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, field_validator

from armsim_ros.config.base import fixed, KeyedSettings, parameter, Settings, unique_names


class ControllerEntry(Settings):
    """What the manager has to know of a controller before it can load it."""

    type: str = parameter(..., 'class of the controller', min_length=1)
    params_file: tuple[str, ...] = parameter((), "files with the controller's parameters")
    fallback_controllers: tuple[str, ...] = parameter(
        (), 'controllers to activate when this controller fails')
    node_options_args: tuple[str, ...] = parameter(
        (), "ROS arguments of the controller's node: remappings and parameters")

    @field_validator('params_file', mode='before')
    @classmethod
    def _one_or_many(cls, value: Any) -> Any:
        return (value,) if isinstance(value, str) else value


class InitialHardwareState(Settings):
    """In which state hardware components start; the others become active."""

    unconfigured: tuple[str, ...] = fixed((), 'components left unconfigured')
    inactive: tuple[str, ...] = fixed((), 'components left inactive')
    shutdown_on_initial_state_failure: bool = fixed(
        True, 'has no effect: simulated hardware reaches every state')

    _unique = field_validator('unconfigured', 'inactive')(unique_names)


class SwitchDefaults(Settings):
    """What a switch request means that leaves its strictness open."""

    strictness: Literal['best_effort', 'strict'] = fixed(
        'best_effort', 'strictness of a request that names none')


class ManagerDefaults(Settings):
    """Defaults of requests."""

    switch_controller: SwitchDefaults = parameter(SwitchDefaults(), 'switch requests')
    allow_controller_activation_with_inactive_hardware: bool = fixed(
        False, 'whether controllers of inactive hardware can be activated')
    deactivate_controllers_on_hardware_self_deactivate: bool = fixed(
        True, 'has no effect: simulated hardware does not deactivate itself')


class Overruns(Settings):
    """What is done where the loop cannot keep its rate."""

    manage: bool = fixed(
        True, 'whether time beyond catch_up is given up; else all of it is made up later')
    print_warnings: bool | None = parameter(
        None, 'whether time that was given up is a warning; by default without use_sim_time')


class Bounds(Settings):
    """From where on a deviation is a warning, and an error."""

    warn: float = parameter(5.0, 'of a warning', gt=0.0)
    error: float = parameter(10.0, 'of an error', gt=0.0)


class Periodicity(Settings):
    """Bounds of a rate [Hz]."""

    mean_error: Bounds = parameter(Bounds(), 'of the mean')
    standard_deviation: Bounds = parameter(Bounds(), 'has no effect: it is not measured')


class ExecutionTime(Settings):
    """Bounds of the time that an update takes [us]."""

    mean_error: Bounds = parameter(Bounds(warn=1000.0, error=2000.0), 'has no effect')
    standard_deviation: Bounds = parameter(Bounds(warn=100.0, error=200.0), 'has no effect')


class LoopThresholds(Settings):
    """Bounds of the whole loop."""

    periodicity: Periodicity = parameter(Periodicity(), 'updates a second')


class PartThresholds(LoopThresholds):
    """Bounds for a single controller or hardware component: read, but without effect."""

    execution_time: ExecutionTime = parameter(ExecutionTime(), 'of an update')


class Thresholds(Settings):
    """From where on diagnostics warn."""

    controller_manager: LoopThresholds = parameter(LoopThresholds(), 'the loop')
    controllers: PartThresholds = parameter(PartThresholds(), 'has no effect')
    hardware_components: PartThresholds = parameter(PartThresholds(), 'has no effect')


class DiagnosticsParameters(Settings):
    """Diagnostics."""

    threshold: Thresholds = parameter(Thresholds(), 'from where on diagnostics warn')


class ControllerManagerParameters(KeyedSettings):
    """Parameters of ``controller_manager``; besides its own keys a block per controller."""

    is_no = "parameter of the manager, and no controller's block with a type"
    __pydantic_extra__: dict[str, ControllerEntry] = Field(init=False)

    update_rate: int = fixed(100, 'updates of the controllers a second [Hz]', ge=1)
    enforce_command_limits: bool = fixed(False, "keep commands within the URDF's limits")
    hardware_components_initial_state: InitialHardwareState = fixed(
        InitialHardwareState(), 'hardware that does not start active')
    defaults: ManagerDefaults = parameter(ManagerDefaults(), 'defaults of requests')
    overruns: Overruns = parameter(Overruns(), 'what is done where the loop is late')
    diagnostics: DiagnosticsParameters = parameter(DiagnosticsParameters(), 'diagnostics')

    @property
    def controllers(self) -> dict[str, ControllerEntry]:
        """Controller -> its block."""
        return self.__pydantic_extra__
