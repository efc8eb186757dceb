# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Settings of a camera (``cameras`` in ``simulation.yaml``)."""

from __future__ import annotations

import math

from pydantic import field_validator

from armsim_ros.config.base import parameter, Settings

Triple = tuple[float, float, float]


class CameraSettings(Settings):
    """A camera that sees colour and depth from the same place."""

    link: str = parameter(
        '', "link that carries it; '' where the URDF has its frame <name>_color_optical_frame",
        read_only=True)
    xyz: Triple = parameter((0.0, 0.0, 0.0), 'where it sits in the link [m]', read_only=True)
    rpy: Triple = parameter(
        (0.0, 0.0, 0.0), 'how it is turned there: x looks forward, z is up [rad]', read_only=True)
    width: int = parameter(640, 'columns of a picture', ge=16, le=4096, read_only=True)
    height: int = parameter(480, 'lines of a picture', ge=16, le=4096, read_only=True)
    rate: float = parameter(10.0, 'pictures a second [Hz]', gt=0.0, le=30.0, read_only=True)
    focal_length: float = parameter(
        1.0, 'focal length over the height of the picture', ge=0.05, le=50.0, read_only=True)
    range: tuple[float, float] = parameter(
        (0.1, 10.0), 'nearest and farthest depth that is measured [m]', read_only=True)

    @field_validator('xyz', 'rpy')
    @classmethod
    def _all_finite(cls, value: Triple) -> Triple:
        if not all(map(math.isfinite, value)):
            raise ValueError('all three numbers must be finite')
        return value

    @field_validator('range')
    @classmethod
    def _rising(cls, value: tuple[float, float]) -> tuple[float, float]:
        if not 0.02 <= value[0] < value[1] <= 1000.0:
            raise ValueError('nearest and farthest must rise between 0.02 and 1000')
        return value
