# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A worker of pytest-xdist that runs core tests with what programs in real time leave over."""

import os
from pathlib import Path

import pytest
from xdist.scheduler import LoadFileScheduling

#: Two at once are as many stacks in real time as two processors carry.
_REAL_TIME_WORKERS = 2
_NICENESS = 10


class SpareWorker:
    """
    A plugin that gives files of real-time tests to two workers only.

    They take those first. A worker beyond the first two takes files of core tests alone, at a
    lower priority.

    :param config: of pytest.
    :param is_real_time: says of a path whether its tests run programs in real time.
    """

    def __init__(self, config, is_real_time):
        self._is_real_time = is_real_time
        worker = os.environ.get('PYTEST_XDIST_WORKER', 'gw0')
        if _is_spare(worker, getattr(config, 'workerinput', {}).get('workercount', 1)):
            os.nice(_NICENESS)

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_make_scheduler(self, config, log):
        """Schedule by file, as ``--dist loadfile`` does."""
        if config.option.dist != 'loadfile':
            return None
        return _Scheduling(config, log, self._is_real_time)


class _Scheduling(LoadFileScheduling):
    def __init__(self, config, log, is_real_time):
        super().__init__(config, log)
        self._root = Path(config.rootpath)
        self._is_real_time = is_real_time

    def _assign_work_unit(self, node):
        spare = _is_spare(node.gateway.id, self.numnodes)
        fitting = [file for file in self.workqueue
                   if self._is_real_time(self._root / file) != spare]
        if fitting:
            self.workqueue.move_to_end(fitting[0], last=False)
        elif spare:
            node.shutdown()
            return
        super()._assign_work_unit(node)


def _is_spare(worker, workers):
    """Return whether a worker is one of the first ones beyond those for real time."""
    return _REAL_TIME_WORKERS <= int(worker.removeprefix('gw')) < workers
