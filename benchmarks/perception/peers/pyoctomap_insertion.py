# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Insertion by OctoMap: reads points from a file, prints processor times [ms] as JSON."""

from __future__ import annotations

import json
import sys
import time

import numpy as np
import pyoctomap


def main(file: str, *resolutions: str) -> None:
    """Insert the cloud three times at each resolution; the last counts."""
    content = np.load(file)
    points, sensor = content['points'].astype(np.float64), content['sensor'].astype(np.float64)
    found = {}
    for resolution in map(float, resolutions):
        for discretize in (False, True):
            tree = pyoctomap.OcTree(resolution)
            for _ in range(3):
                begin = time.process_time()
                tree.insertPointCloud(points, sensor, discretize=discretize)
                took = time.process_time() - begin
            found[f'{resolution:g} {discretize}'] = 1e3 * took
    print(json.dumps(found))


main(*sys.argv[1:])
