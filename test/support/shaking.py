# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What tries to shake a cube out of the fingers."""

import numpy as np

from armsim_ros.trajectory import JointTrajectory

GRAVITY = 9.8


def shaking(seconds):
    """Return a circle in x and z, once a second, that accelerates by one gravity."""
    times = np.arange(0.0, seconds + 1e-9, 0.02)
    share = np.clip(0.5 * np.minimum(times, seconds - times), 0.0, 1.0)
    radius = GRAVITY / (2.0 * np.pi) ** 2 * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    angle = 2.0 * np.pi * times
    positions = radius[:, None] * np.column_stack([np.sin(angle), np.cos(angle)])
    velocities = np.gradient(positions, times, axis=0)
    velocities[-1] = 0.0
    accelerations = np.gradient(velocities, times, axis=0)
    return JointTrajectory(
        ('carriage_x', 'carriage_z'), 0.02 + times, positions, velocities, accelerations)
