# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The jobs of the test suite: plugins that choose tests and give them to the workers."""

import pytest
from xdist.scheduler import LoadScopeScheduling

#: Tests that compute; tests that run programs; those of the latter that need the machine alone.
CORE, REAL_TIME, ALONE = JOBS = ('core', 'real-time', 'alone')


class ChosenJob:
    """
    A plugin that leaves out the tests of other jobs.

    :param job: whose tests run.
    :param real_time: folders whose tests run programs, in the order in which they run.
    """

    def __init__(self, job, real_time):
        self._job, self._real_time = job, real_time

    def pytest_ignore_collect(self, collection_path):
        """Do not even import what computes where programs run, and the other way round."""
        if collection_path.suffix != '.py':
            return None
        runs_programs = any(map(collection_path.is_relative_to, self._real_time))
        return True if runs_programs == (self._job == CORE) else None

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, config, items):
        """Keep what is marked as alone for the job of that name, in the order of the folders."""
        if self._job == CORE:
            return
        items.sort(key=lambda item: next(
            place for place, each in enumerate(self._real_time) if item.path.is_relative_to(each)))
        chosen, others = [], []
        for item in items:
            alone = item.get_closest_marker('alone') is not None
            (chosen if alone == (self._job == ALONE) else others).append(item)
        items[:] = chosen
        config.hook.pytest_deselected(items=others)


class ByStack:
    """
    A plugin that gives workers whole files, and whole folders where these share a stack.

    :param folders: whose tests share a stack.
    """

    def __init__(self, folders):
        self._folders = folders

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_make_scheduler(self, config, log):
        """Give the scheduler of ``--dist loadfile``, with larger units."""
        if config.option.dist != 'loadfile':
            return None
        return _Scheduling(config, log, self._folders)


class _Scheduling(LoadScopeScheduling):
    def __init__(self, config, log, folders):
        super().__init__(config, log)
        self._folders = folders

    def _split_scope(self, nodeid):
        file = self.config.rootpath / nodeid.partition('::')[0]
        return str(next((each for each in self._folders if file.is_relative_to(each)), file))

    def remove_node(self, node):
        """
        Return the test whose worker died; others run what the worker had left.

        Upstream runs that test again, too, until all replacements of workers are used up.
        """
        units = self.assigned_work[node]
        died = next(
            (test for unit in units.values() for test, done in unit.items() if not done), None)
        left = {name: {test: False for test, done in unit.items() if not done and test != died}
                for name, unit in units.items()}
        self.assigned_work[node] = {name: unit for name, unit in left.items() if unit}
        super().remove_node(node)
        return died
