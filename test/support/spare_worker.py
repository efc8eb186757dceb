# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A worker of pytest-xdist that uses what time programs in real time leave over."""

from enum import Enum
import os
from pathlib import Path

import pytest
from xdist.scheduler import LoadFileScheduling

#: Two at once are as many stacks in real time as two processors carry.
_REAL_TIME_WORKERS = 2
_NICENESS = 10


class Kind(Enum):
    """What the tests of a file need of the machine."""

    #: They run programs whose times they look at.
    REAL_TIME = 'real time'
    #: They run programs, and may take their time.
    PATIENT = 'patient'
    #: They compute.
    CORE = 'core'


class SpareWorker:
    """
    A plugin that gives files of real-time tests to two workers only.

    They take those first, and what computes last. A worker beyond the first two begins with
    that, at a lower priority, and takes no tests of real time.

    :param config: of pytest.
    :param kind_of: says of a path what kind its tests are.
    """

    def __init__(self, config, kind_of):
        self._kind_of = kind_of
        worker = os.environ.get('PYTEST_XDIST_WORKER', 'gw0')
        if _is_spare(worker, getattr(config, 'workerinput', {}).get('workercount', 1)):
            os.nice(_NICENESS)

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_make_scheduler(self, config, log):
        """Schedule by file, as ``--dist loadfile`` does."""
        if config.option.dist != 'loadfile':
            return None
        return _Scheduling(config, log, self._kind_of)


class _Scheduling(LoadFileScheduling):
    def __init__(self, config, log, kind_of):
        super().__init__(config, log)
        self._root = Path(config.rootpath)
        self._kind_of = kind_of

    def _assign_work_unit(self, node):
        order = [Kind.REAL_TIME, Kind.PATIENT, Kind.CORE]
        if _is_spare(node.gateway.id, self.numnodes):
            order = [Kind.CORE, Kind.PATIENT]
        kinds = {file: self._kind_of(self._root / file) for file in self.workqueue}
        fitting = [file for file, kind in kinds.items() if kind in order]
        if not fitting:
            node.shutdown()
            return
        first = min(fitting, key=lambda file: order.index(kinds[file]))
        self.workqueue.move_to_end(first, last=False)
        super()._assign_work_unit(node)


def _is_spare(worker, workers):
    """Return whether a worker is one of the first ones beyond those for real time."""
    return _REAL_TIME_WORKERS <= int(worker.removeprefix('gw')) < workers
