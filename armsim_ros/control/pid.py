# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""PID of a joint, with the anti-windup strategies of control_toolbox."""

from __future__ import annotations

import math

from armsim_ros.config.controllers.pid_controller import PidGains


class Pid:
    """
    ``u = p*e + I + d*de`` within its bounds.

    ``I`` is the integral part. How it is kept from winding up is the gains'
    ``antiwindup_strategy``: ``legacy`` bounds it by the i clamps, ``back_calculation`` bleeds it
    by what the output bounds cut off, ``conditional_integration`` stops it while the output is
    saturated and the error would drive it further, ``none`` lets it grow. The clamps hold for
    every strategy.
    """

    __slots__ = ('_deadband', '_gains', '_integral', '_lower', '_output', '_strategy',
                 '_time_constant', '_upper')

    def __init__(self, gains: PidGains) -> None:
        self._integral = 0.0
        self._output = 0.0
        self.set_gains(gains)

    def set_gains(self, gains: PidGains) -> None:
        """Change the gains; the integral part is kept as far as its new bounds allow."""
        self._gains = gains
        self._lower, self._upper = gains.integral_bounds
        self._strategy = gains.antiwindup_strategy
        self._deadband = gains.error_deadband
        self._time_constant = gains.tracking_time_constant or _time_constant(gains)
        self._integral = min(max(self._integral, self._lower), self._upper)

    def reset(self) -> None:
        """Forget the integral part and the last output."""
        self._integral = 0.0
        self._output = 0.0

    def compute(self, error: float, error_rate: float, period: float) -> float:
        """
        Return the output for a period.

        :param error: desired minus measured [rad or m].
        :param error_rate: desired minus measured velocity [rad/s or m/s].
        :param period: [s]; 0 repeats the last output.
        :returns: NaN where an error is not finite, and the integral part stays as it was.
        """
        if period <= 0.0:
            return self._output
        if not (math.isfinite(error) and math.isfinite(error_rate)):
            return math.nan
        gains = self._gains
        linear = gains.p * error + gains.d * error_rate
        strategy = self._strategy
        step = gains.i * error * period if abs(error) > self._deadband else 0.0
        if strategy in ('legacy', 'none'):
            self._integral = min(max(self._integral + step, self._lower), self._upper)
        free = linear + self._integral
        output = min(max(free, gains.u_clamp_min), gains.u_clamp_max)
        if strategy == 'back_calculation':
            if gains.i:
                step += (output - free) * period / self._time_constant
            self._integral = min(max(self._integral + step, self._lower), self._upper)
        elif strategy == 'conditional_integration' and (output == free or error * free <= 0.0):
            self._integral = min(max(self._integral + step, self._lower), self._upper)
        self._output = output
        return output


def _time_constant(gains: PidGains) -> float:
    """Return sqrt(d / i), or p / i without d [s]: the usual choice for back calculation."""
    if gains.i == 0.0:
        return 1.0
    ratio = gains.d / gains.i if gains.d else (gains.p / gains.i) ** 2
    return math.sqrt(abs(ratio)) or 1.0
