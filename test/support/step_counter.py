# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A small environment that workers can import."""

from threading import Lock

import gymnasium
import numpy as np

#: Actions at which its step raises.
FAILS, INTERRUPTED = 13.0, 14.0
#: Name of an attribute that no other process can have.
UNPICKLABLE = 'lock'


class StepCounter(gymnasium.Env):
    """Observes how many steps its episode has, and how many episodes it began."""

    observation_space = gymnasium.spaces.Box(0.0, 100.0, (2,), np.float64)
    action_space = gymnasium.spaces.Box(-100.0, 100.0, (1,), np.float64)
    length = 3
    lock = Lock()

    def __init__(self):
        self.state = np.zeros(2)

    def reset(self, *, seed=None, options=None):
        """Begin an episode."""
        super().reset(seed=seed)
        self.state = np.array([0.0, self.state[1] + 1.0])
        return self.state.copy(), {}

    def step(self, action):
        """Count; the last step of an episode truncates it."""
        if action[0] == FAILS:
            raise RuntimeError('no reward')
        if action[0] == INTERRUPTED:
            raise KeyboardInterrupt
        self.state[0] += 1.0
        return self.state.copy(), 0.0, False, self.state[0] >= self.length, {}
