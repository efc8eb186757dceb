# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Finds what stops an arm: its speed, its position, and loads from outside."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.control.arm_state import Cause
from armsim_ros.control.hardware_interface import HardwareInterface, JointProperties
from armsim_ros.model.robot_model import RobotModel

#: So many times its limit a joint may be fast.
SPEED_SHARE = 1.2
#: So far a joint may be outside of its bounds [rad or m].
BEYOND = 0.01
#: A load counts after this time, so that the first impact of a contact does not [ns].
LASTING_NS = 10_000_000
_NEVER_NS = -1


class Loads(Protocol):
    """What acts on an arm from outside."""

    def torques(self) -> Vector:
        """Return the external torque of each joint (n,) [N*m or N]."""

    def hardest_contact(self) -> tuple[float, str]:
        """Return the greatest force of a contact of the arm [N], and the bodies."""


class StopMonitor:
    """
    Checks the state of an arm's joints in each control period.

    :param loads: None where there are no such limits.
    :param torques: (n,) of the joints that may act from outside [N*m or N].
    :param force: of a contact [N].
    """

    def __init__(
        self, hardware: HardwareInterface, model: RobotModel | None, loads: Loads | None,
        torques: Vector, force: float
    ) -> None:
        names = hardware.joint_names
        properties = JointProperties.of(names, model)
        self._names, self._units = names, properties.units
        self._state, self._loads = hardware.state, loads
        self._fastest = SPEED_SHARE * properties.velocity
        self._lower, self._upper = properties.lower - BEYOND, properties.upper + BEYOND
        #: (n,) greatest external torques; may be replaced.
        self.torques = torques
        #: Greatest contact force [N]; may be replaced.
        self.force = force
        #: Since when torques, and contacts, are above their limits [ns].
        self._since_ns = [_NEVER_NS, _NEVER_NS]

    @property
    def has_loads(self) -> bool:
        """Whether loads from outside are measured."""
        return self._loads is not None

    def check(self, time_ns: int, *, yielding: bool = False) -> Cause | None:
        """
        Return why the arm has to stop, None where it may go on.

        :param time_ns: now [ns].
        :param yielding: whether the arm yields to loads, which do not stop it then.
        """
        velocity, position = self._state.velocity, self._state.position
        if (np.abs(velocity) > self._fastest).any():
            i = int(np.argmax(np.abs(velocity) - self._fastest))
            return self._cause('speed', i, float(abs(velocity[i])), float(self._fastest[i]), '/s')
        if (position < self._lower).any() or (position > self._upper).any():
            outside = np.maximum(self._lower - position, position - self._upper)
            i = int(np.argmax(outside))
            bound = self._lower[i] if position[i] < self._lower[i] else self._upper[i]
            return self._cause('position', i, float(position[i]), float(bound))
        return None if yielding else self.load(time_ns)

    def load(self, time_ns: int | None = None) -> Cause | None:
        """
        Return which load from outside is too great, None where none is.

        :param time_ns: now, for those that have lasted; None for any that there is [ns].
        """
        if self._loads is None:
            return None
        torques = np.abs(self._loads.torques())
        if self._lasts(0, time_ns, bool((torques > self.torques).any())):
            i = int(np.argmax(torques - self.torques))
            unit = 'N' if self._units[i] == 'm' else 'N*m'
            return Cause('collision', f"external torque of joint '{self._names[i]}' "
                         f'{torques[i]:.1f} {unit}, limit {self.torques[i]:g} {unit}',
                         self._names[i])
        if self.force == np.inf:
            return None
        force, bodies = self._loads.hardest_contact()
        if self._lasts(1, time_ns, force > self.force):
            return Cause('collision', f'contact of {bodies} {force:.1f} N, limit {self.force:g} N')
        return None

    def _lasts(self, load: int, time_ns: int | None, above: bool) -> bool:
        """Return whether a load is above its limit, and for how long it has to be."""
        since = self._since_ns
        if time_ns is None or not above:
            since[load] = _NEVER_NS
            return above
        if since[load] == _NEVER_NS or time_ns < since[load]:
            since[load] = time_ns
        return time_ns - since[load] >= LASTING_NS

    def _cause(self, kind: str, i: int, value: float, limit: float, rate: str = '') -> Cause:
        unit = (self._units[i] or 'rad') + rate
        return Cause('speed' if kind == 'speed' else 'position',
                     f"joint '{self._names[i]}' {value:.3f} {unit}, limit {limit:.3f} {unit}",
                     self._names[i])
