# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which planning pipelines are offered, and which of them is the default."""

import logging

import pytest

from armsim_ros.config.ompl_planning import offered_pipelines, PipelineSettings, PlanningParameters
from armsim_ros.config.pipeline_defaults import PILZ_PLUGIN

PIPELINES = {
    'ompl': PipelineSettings(),
    'pilz': PipelineSettings(planning_plugins=(PILZ_PLUGIN,)),
    'stomp': PipelineSettings(planning_plugins=('stomp_moveit/StompPlanner',)),
    'both': PipelineSettings(planning_plugins=('ompl_interface/OMPLPlanner', PILZ_PLUGIN)),
    'none': PipelineSettings(planning_plugins=()),
}


@pytest.fixture
def offered(caplog):
    """Return what gives the parameters of a list and a default, and what was logged."""
    def parameters(names, default=''):
        found = offered_pipelines(
            PlanningParameters(planning_pipelines=names, default_planning_pipeline=default),
            PIPELINES, logging.getLogger('pipelines'))
        return found.planning_pipelines, found.default_planning_pipeline, caplog.text

    return parameters


@pytest.mark.parametrize(('names', 'default', 'expected'), [
    (('ompl', 'pilz'), 'pilz', 'pilz'), (('pilz', 'ompl'), '', 'pilz'), (('pilz',), '', 'pilz'),
])
def test_the_default_pipeline(offered, names, default, expected):
    """It is the first of the list where none is given."""
    assert offered(names, default) == (names, expected, '')


def test_a_default_that_is_not_in_the_list(offered):
    """
    The first of the list is used, with a warning.

    Upstream: move_group.cpp, main.
    """
    names, default, log = offered(('pilz',), 'ompl')
    assert (names, default) == (('pilz',), 'pilz')
    assert "default_planning_pipeline 'ompl' is not among" in log


@pytest.mark.parametrize(('name', 'reason'), [
    ('stomp', 'stomp_moveit/StompPlanner'), ('both', f'ompl_interface/OMPLPlanner, {PILZ_PLUGIN}'),
    ('none', 'planning_plugins is empty'), ('lost', 'planning_plugins is empty'),
])
def test_a_pipeline_that_cannot_plan(offered, name, reason):
    """It is left out, with a line about its plugins."""
    names, _, log = offered((name, 'ompl'))
    assert names == ('ompl',)
    assert f"planning pipeline '{name}' is not offered" in log
    assert reason in log
