# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Settings of the physics, the joints' servos and the pace (``simulation.yaml``)."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.pid_gains import PidGains

Triple = tuple[float, float, float]


def finite_triple(value: Triple) -> Triple:
    """Return three numbers as they are; ValueError where one is not finite."""
    if not all(math.isfinite(number) for number in value):
        raise ValueError('all three numbers must be finite')
    return value


class ServoSettings(Settings):
    """How a position or velocity command becomes a torque."""

    feedforward: bool = parameter(
        True, 'add the inverse dynamics of the reference to the gains', read_only=True
    )
    default_gains: PidGains = parameter(
        PidGains(p=1000.0, d=0.1, i_clamp=0.0),
        'p, i, d, i_clamp of joints for which no controller gives any',
        read_only=True,
    )
    gains: dict[str, PidGains] = parameter(
        {}, 'joint -> gains that win over those of its controller', read_only=True
    )
    damping_ratio: float = parameter(
        0.7,
        'the derivative gain is raised to at least this ratio of critical damping, so that an '
        'arm that was pushed comes to rest; 0 takes the gains as they are',
        ge=0.0,
        le=2.0,
        read_only=True,
    )


class PlacementSettings(Settings):
    """Where the robot's root link stands in the world."""

    xyz: Triple = parameter((0.0, 0.0, 0.0), 'position [m]', read_only=True)
    rpy: Triple = parameter((0.0, 0.0, 0.0), 'roll, pitch, yaw [rad]', read_only=True)

    _all_finite = field_validator('xyz', 'rpy')(finite_triple)


class PaceSettings(Settings):
    """How the loop keeps to the wall clock; deterministic runs use none of it."""

    priority: int = parameter(
        10,
        'SCHED_FIFO priority asked for, 0 asks for none; without the permission the loop runs '
        'at normal priority',
        ge=0,
        le=99,
        read_only=True,
    )
    spin: float = parameter(
        0.0, 'last part of a wait that is spent polling the clock [s]', ge=0.0, le=0.001
    )
    catch_up: float = parameter(
        0.1,
        'delay that is made up by ticks without a wait [s]; what is beyond is dropped, counted '
        'and reported',
        ge=0.0,
        le=10.0,
    )


class SimulationSettings(Settings):
    """Everything about the simulated plant that is not the robot and not the world."""

    timestep: float = parameter(
        0.001, 'time of one physics step [s]', ge=0.0001, le=0.01, read_only=True
    )
    integrator: Literal['implicitfast', 'implicit', 'euler'] = parameter(
        'implicitfast', "MuJoCo's integrator", read_only=True
    )
    gravity: Triple = parameter((0.0, 0.0, -9.8), 'gravity [m/s^2]', read_only=True)
    armature: float = parameter(
        0.01,
        'least inertia of rotor and gear that each rotating joint carries [kg*m^2]; a light arm '
        'is unstable without it',
        ge=0.0,
        read_only=True,
    )
    armature_linear: float = parameter(
        0.1, 'the same for each sliding joint [kg]', ge=0.0, read_only=True
    )
    servo: ServoSettings = parameter(ServoSettings(), 'servo of the joints')
    world: str = parameter('', "world file or its name; '' is a floor and nothing on it")
    placement: PlacementSettings = parameter(PlacementSettings(), 'where the robot stands')
    initial_state: str = parameter(
        '', "named state of the SRDF to start in, 'state' or 'group/state'", read_only=True
    )
    initial_positions: dict[str, float] = parameter(
        {}, 'joint -> position at the start [rad or m]; wins over the named state', read_only=True
    )
    deterministic: bool = parameter(
        False, 'no wall clock: time starts at zero and only steps move it', read_only=True
    )
    paused: bool = parameter(False, 'start with the physics standing still', read_only=True)
    real_time_factor: float = parameter(
        1.0, 'simulated time per wall time; 1 is real time', gt=0.0, le=100.0
    )
    clock_rate: float = parameter(
        100.0, 'rate of /clock in simulated time [Hz]', gt=0.0, le=1000.0, read_only=True
    )
    fault_injection: bool = parameter(
        False,
        'for tests: joints can be made to fail by the parameters faults.<joint>.lag, .bias and '
        '.blocked of the controller manager',
        read_only=True,
    )
    pace: PaceSettings = parameter(PaceSettings(), 'how the loop keeps to the wall clock')

    _finite_gravity = field_validator('gravity')(finite_triple)

    @field_validator('initial_positions')
    @classmethod
    def _finite_positions(cls, value: dict[str, float]) -> dict[str, float]:
        wrong = [name for name, position in value.items() if not math.isfinite(position)]
        if wrong:
            raise ValueError(f"the position of '{wrong[0]}' must be finite")
        return value

    @model_validator(mode='after')
    def _whole_nanoseconds(self) -> Self:
        nanoseconds = self.timestep * 1e9
        if abs(nanoseconds - round(nanoseconds)) > 1e-3:
            raise ValueError('timestep must be a whole number of nanoseconds')
        return self

    @property
    def timestep_ns(self) -> int:
        """Time of one physics step [ns]."""
        return round(self.timestep * 1e9)
