# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Limits of the tool's own motion (``pilz_cartesian_limits.yaml``)."""

from __future__ import annotations

from armsim_ros.config.base import parameter, Settings


class CartesianLimits(Settings):
    """How fast the tool may move on lines and arcs; the defaults are the usual template's."""

    max_trans_vel: float = parameter(1.0, 'largest speed [m/s]', gt=0.0)
    max_trans_acc: float = parameter(2.25, 'largest acceleration [m/s^2]', gt=0.0)
    max_trans_dec: float = parameter(-5.0, 'largest deceleration, below 0 [m/s^2]', lt=0.0)
    max_rot_vel: float = parameter(1.57, 'largest turning speed [rad/s]', gt=0.0)
