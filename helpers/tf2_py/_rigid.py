# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Rigid transforms as tuples of floats.

For single transforms this is several times faster than arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import acos, sin, sqrt
from typing import TypeAlias

#: Rotation x, y, z, w and translation x, y, z [m].
Pose: TypeAlias = tuple[float, float, float, float, float, float, float]
#: Stamp [ns], parent frame, and the child's pose in it as in Pose.
Sample: TypeAlias = tuple[int, str, float, float, float, float, float, float, float]

IDENTITY: Pose = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def interpolate(older: Sample, newer: Sample, time: int) -> Sample:
    """
    Return the pose between two samples: linear translation, spherical linear rotation.

    :param time: [ns], from the older stamp on and before the newer.
    """
    stamp, parent, ax, ay, az, aw, ox, oy, oz = older
    end, _, bx, by, bz, bw, nx, ny, nz = newer
    late = (time - stamp) / (end - stamp)
    early = 1.0 - late
    x, y, z = ox * early + nx * late, oy * early + ny * late, oz * early + nz * late
    cosine = ax * bx + ay * by + az * bz + aw * bw
    sign = 1.0
    if cosine < 0.0:
        cosine, sign = -cosine, -1.0
    if cosine < 1.0:
        half_angle = acos(cosine)
        scale = 1.0 / sin(half_angle)
        early = sin(early * half_angle) * scale
        late = sin(late * half_angle) * scale * sign
        ax, ay = ax * early + bx * late, ay * early + by * late
        az, aw = az * early + bz * late, aw * early + bw * late
    return stamp, parent, ax, ay, az, aw, x, y, z


def compose(chain: Sequence[Sample]) -> Pose:
    """Return the pose of the first sample's child in the last sample's parent."""
    if not chain:
        return IDENTITY
    _, _, x, y, z, w, a, b, c = chain[0]
    for _, _, px, py, pz, pw, pa, pb, pc in chain[1:]:
        # The vector part of p times (a, b, c), twice.
        u = py * c - pz * b
        v = pz * a - px * c
        s = px * b - py * a
        u += u
        v += v
        s += s
        a += pw * u + py * s - pz * v + pa
        b += pw * v + pz * u - px * s + pb
        c += pw * s + px * v - py * u + pc
        x, y, z, w = (pw * x + px * w + py * z - pz * y, pw * y - px * z + py * w + pz * x,
                      pw * z + px * y - py * x + pz * w, pw * w - px * x - py * y - pz * z)
    return x, y, z, w, a, b, c


def inverse(pose: Pose) -> Pose:
    """Return the inverse of a pose."""
    x, y, z, w, a, b, c = pose
    u, v, s = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return (-x, -y, -z, w, -(a - w * u + y * s - z * v), -(b - w * v + z * u - x * s),
            -(c - w * s + x * v - y * u))


def product(first: Pose, second: Pose) -> Pose:
    """Return first times second: what second maps, then mapped by first."""
    return compose([(0, '', *second), (0, '', *first)])


def unit(x: float, y: float, z: float, w: float) -> tuple[float, float, float, float]:
    """
    Return a quaternion of length 1, with the sign that tf2's conversion from a matrix gives.

    w is positive for rotations below 120 degrees; beyond, the largest of x, y, z is.
    """
    scale = 1.0 / sqrt(x * x + y * y + z * z + w * w)
    w *= scale
    leading = w
    if w * w <= 0.25:
        leading = x if abs(x) >= abs(y) else y
        if abs(z) > abs(leading):
            leading = z
    if leading < 0.0:
        return -x * scale, -y * scale, -z * scale, -w
    return x * scale, y * scale, z * scale, w
