# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
TRAC-IK in its own environment: one JSON line in, one out.

In: ``urdf``, ``base``, ``tip``, ``timeout`` [s], ``targets`` with ``position``, ``rotation`` and
``seed`` each. Out: ``answers`` with ``values`` (or null) and ``seconds`` of all threads each.
"""

from __future__ import annotations

import json
import os
import sys
import time

import numpy as np
from trac_ik import TracIK


def main() -> None:
    """Answer one question."""
    out = os.fdopen(os.dup(1), 'w', encoding='utf-8')
    os.dup2(2, 1)  # what libraries print must not be taken for an answer
    asked = json.loads(sys.stdin.readline())
    solver = TracIK(asked['base'], asked['tip'], asked['urdf'], timeout=asked['timeout'])
    answers = []
    for target in asked['targets']:
        position, rotation = np.array(target['position']), np.array(target['rotation'])
        seed = np.array(target['seed'])
        began = time.process_time()
        values = solver.ik(position, rotation, seed)
        seconds = time.process_time() - began
        answers.append(
            {'values': None if values is None else list(map(float, values)), 'seconds': seconds})
    print(json.dumps({'answers': answers}), file=out, flush=True)


main()
