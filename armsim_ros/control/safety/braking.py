# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Brings the joints of an arm to rest and holds them there, whatever its controllers do.

All joints take the same time, so that the arm stays on the tangent of its path.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.control.hardware_interface import (
    ACCELERATION,
    COMMAND_INTERFACES,
    HardwareInterface,
)
from armsim_ros.model.robot_model import RobotModel

#: Deceleration of joints without a limit [rad/s^2 or m/s^2].
DECELERATION = 10.0
#: All joints rest at the latest after this time [s].
LONGEST_STOP = 0.4
#: Where a command is farther from its joint, the motion goes on from the joint [rad or m].
NEAR = 0.02
#: Share of its speed that a joint keeps from one control period to the next while it yields.
YIELD = 0.98


class Braking:
    """
    A stop of some joints.

    :param joints: those that are stopped.
    :param model: gives limits of acceleration.
    """

    def __init__(
        self, hardware: HardwareInterface, model: RobotModel | None, joints: Sequence[str]
    ) -> None:
        self.joints = frozenset(joints)
        self._hardware = hardware
        self._places = np.array([hardware.index[name] for name in joints], dtype=np.intp)
        known = model.hardware_joints if model is not None else {}
        limits = [abs(known[name].bounds[ACCELERATION][0]) if name in known
                  and ACCELERATION in known[name].bounds else np.inf for name in joints]
        self._limits = np.array([limit if 0.0 < limit < np.inf else DECELERATION
                                 for limit in limits])
        self._start = self._velocity = np.zeros(len(joints))
        self._duration = self._time = 0.0
        self._way: Vector | None = None

    def measure(self, *, measured: bool) -> Vector:
        """
        Return how fast the joints are to be when they begin to slow down (n,).

        :param measured: whether the joints' own motion counts, not that of their commands.
        """
        hardware, places = self._hardware, self._places
        velocity = hardware.state.velocity[places].copy()
        given = hardware.feedforward.velocity[places]
        if not measured:
            follows = np.isfinite(given) & self._near()
            velocity[follows] = given[follows]
        return velocity

    def begin(self, velocity: Vector, *, measured: bool) -> None:
        """
        Begin to slow down from what the drives follow now.

        :param velocity: (n,) at the begin [rad/s or m/s].
        :param measured: as for ``measure``.
        """
        hardware, places = self._hardware, self._places
        self._start = hardware.state.position[places].copy()
        if not measured:
            near = self._near()
            self._start[near] = hardware.command.position[places][near]
        self._velocity, self._way = velocity, None
        longest = float(np.max(np.abs(velocity) / self._limits, initial=0.0))
        self._duration, self._time = min(longest, LONGEST_STOP), 0.0

    def halt(self) -> None:
        """Slow down whatever moves the stopped arm."""
        yields = self._way is None and self.at_rest
        self.begin(self.measure(measured=yields), measured=yields)

    def move(self, targets: Sequence[float] | None, speed: float, acceleration: float,
             duration: float) -> None:
        """Move on from where the joints are commanded to be, see ``ArmStop.move``."""
        here = self._hardware.command.position[self._places].copy()
        way = np.zeros_like(here) if targets is None else np.array(targets) - here
        farthest = float(np.max(np.abs(way), initial=0.0))
        if farthest > 0.0 and not duration:
            # A quintic from rest to rest has 15/8 of its mean speed and 10/sqrt(3) of
            # distance / time^2 as greatest values.
            duration = max(1.875 * farthest / speed, (5.7735 * farthest / acceleration)**0.5)
        self._start, self._way = here, way if farthest > 0.0 else None
        self._velocity = np.zeros_like(here)
        self._duration, self._time = duration if farthest > 0.0 else 0.0, 0.0

    def write(self, period: float, *, yielding: bool = False) -> None:
        """
        Command where the joints are to be a period [s] ahead; nothing else reaches them.

        :param yielding: whether the joints go where forces from outside move them.
        """
        self._time += period
        hardware, places, whole = self._hardware, self._places, self._duration
        position, velocity = self._start, np.zeros_like(self._velocity)
        acceleration = velocity
        if self._way is not None:
            u = min(self._time / whole, 1.0)
            position = position + self._way * (u**3 * (10.0 - 15.0 * u + 6.0 * u**2))
            velocity = self._way * (30.0 * u**2 * (1.0 - u)**2 / whole)
            acceleration = self._way * (60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / whole**2)
        elif whole > 0.0:
            time = min(self._time, whole)
            position = position + self._velocity * (time - time**2 / (2.0 * whole))
            velocity = self._velocity * (1.0 - time / whole)
            if time < whole:
                acceleration = -self._velocity / whole
        elif yielding:
            velocity = YIELD * hardware.state.velocity[places]
            position = self._start = hardware.state.position[places] + period * velocity
        for kind in COMMAND_INTERFACES:
            hardware.command.of(kind)[places] = np.nan
            hardware.feedforward.of(kind)[places] = np.nan
        hardware.command.position[places] = position
        hardware.feedforward.velocity[places] = velocity
        hardware.feedforward.acceleration[places] = acceleration

    @property
    def at_rest(self) -> bool:
        """Whether the commands stay as they are."""
        return self._time >= self._duration

    def _near(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        hardware, places = self._hardware, self._places
        distance = np.abs(hardware.command.position[places] - hardware.state.position[places])
        near: np.ndarray[tuple[int], np.dtype[np.bool_]] = distance < NEAR  # NaN is not near
        return near
