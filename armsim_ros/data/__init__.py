# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Data sets of episodes in LeRobot's layout v3.0.

It needs pyarrow, and PyAV for pictures: ``pip install 'armsim_ros[gym,data]'``.
"""

from armsim_ros.data.collect import collect, Collected, Plan, replay, Replayed
from armsim_ros.data.dataset import DataSet, EpisodeData
from armsim_ros.data.features import Feature

__all__ = ['Collected', 'DataSet', 'EpisodeData', 'Feature', 'Plan', 'Replayed', 'collect',
           'replay']
