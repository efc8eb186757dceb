# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gymnasium's base and spaces where it is installed, else our own of the same shape."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

__all__ = ['HAS_GYMNASIUM', 'Box', 'Dict', 'Env']

HAS_GYMNASIUM = find_spec('gymnasium') is not None

if TYPE_CHECKING or not HAS_GYMNASIUM:
    from armsim_ros.env.own_gym import Box, Dict, Env
else:
    from gymnasium import Env
    from gymnasium.spaces import Box, Dict
