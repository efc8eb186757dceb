# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the way from a planner's name to a planner."""

import pytest

from armsim_ros.config.ompl_planning import PipelineSettings, PlanningParameters
from armsim_ros.errors import PlanningError
from armsim_ros.planning.context import settings_from_config
from armsim_ros.planning.search.planners import PLANNER_TYPES, PlannerTable

MOVEIT_TYPES = (
    'AnytimePathShortening', 'BFMT', 'BiEST', 'BiTRRT', 'BKPIECE', 'EST', 'FMT', 'KPIECE',
    'LazyPRM', 'LazyPRMstar', 'LazyRRT', 'LBKPIECE', 'LBTRRT', 'PDST', 'PRM', 'PRMstar',
    'ProjEST', 'RRT', 'RRTConnect', 'RRTstar', 'SBL', 'SPARS', 'SPARStwo', 'STRIDE', 'TRRT',
)

TABLE = PlannerTable({
    'arm': {'type': 'geometric::RRTstar'},
    'arm[fast]': {'type': 'geometric::RRT', 'goal_bias': 0.1},
    'arm[odd]': {'type': 'geometric::Nothing'},
    'other[fast]': {'type': 'geometric::RRTConnect', 'range': 0.3},
})


@pytest.mark.parametrize('name', MOVEIT_TYPES)
def test_every_type_is_understood(name, log):
    """OMP-1: all 25 planner types lead to a planner."""
    table = PlannerTable({'arm[x]': {'type': f'geometric::{name}'}})
    assert table.choose('x', 'arm', log).type in PLANNER_TYPES


def test_a_type_that_is_not_bound_is_replaced_with_a_warning(log):
    """OMP-1: a planner that OMPL's Python package lacks gives the nearest one, and says so."""
    assert PlannerTable({'arm': {'type': 'geometric::EST'}}).choose('', 'arm', log).type \
        == 'KPIECE'
    assert 'using geometric::KPIECE' in log.recorder.text()


@pytest.mark.parametrize(('planner_id', 'group', 'kind'), [
    ('fast', 'arm', 'RRT'), ('arm[fast]', 'arm', 'RRT'), ('arm', 'arm', 'RRTstar'),
    ('', 'arm', 'RRTstar'), ('fast', 'other', 'RRTConnect'), ('', 'other', 'RRTConnect'),
])
def test_ids_of_planner_configurations(log, planner_id, group, kind):
    """
    An id with the group's name is looked up as it is, any other as ``group[id]``.

    Upstream: planning_context_manager.cpp, getPlanningContext.
    """
    assert TABLE.choose(planner_id, group, log).type == kind
    assert not log.recorder.lines


@pytest.mark.parametrize('planner_id', ['fsat', 'RRT', 'geometric::RRT', 'other[fast]', 'arm[]'])
def test_unknown_id_is_the_default_with_a_warning(log, planner_id):
    """
    An id that is not configured for the group gives the group's default.

    Upstream: planning_context_manager.cpp, getPlanningContext.
    """
    assert TABLE.choose(planner_id, 'arm', log).type == 'RRTstar'
    assert f"'{planner_id}' is not configured for group 'arm'" in log.recorder.text()


def test_a_group_without_settings_has_rrt_connect(log):
    """
    Without a default configuration a group's planner is RRTConnect.

    Upstream: ompl_interface.cpp, loadPlannerConfigurations.
    """
    assert PlannerTable().choose('', 'arm', log).type == 'RRTConnect'


def test_unknown_type_is_an_error(log):
    """OMP-1: a configuration with an unknown type cannot be used."""
    with pytest.raises(PlanningError, match="unknown type 'geometric::Nothing'") as caught:
        TABLE.choose('odd', 'arm', log)
    assert caught.value.code == -1


def test_ids_for_clients():
    """
    Clients are offered each group and the configurations of groups.

    Upstream: ompl_planner_manager.cpp, getPlanningAlgorithms.
    """
    assert PlannerTable({'arm[fast]': {}, 'arm': {}}).planner_ids(('arm', 'hand')) == (
        'arm', 'arm[fast]', 'hand')


def test_configurations_of_groups():
    """
    A configuration has the group's settings below its own; unknown names are left out.

    Upstream: ompl_interface.cpp, loadPlannerConfigurations.
    """
    pipeline = PipelineSettings(
        planner_configs={'fast': {'type': 'geometric::RRT', 'goal_bias': 0.1},
                         'star': {'type': 'geometric::RRTstar'}},
        groups={'arm': {'default_planner_config': 'star', 'planner_configs': ('fast', 'lost'),
                        'longest_valid_segment_fraction': 0.01},
                'hand': {'default_planner_config': 'lost'}})
    parameters = PlanningParameters(planning_pipelines=('ompl',))
    table = settings_from_config(parameters, {'ompl': pipeline}, {}).pipelines['ompl'].planners
    fraction = {'longest_valid_segment_fraction': 0.01}
    assert table.configs == {
        'arm': {'type': 'geometric::RRTstar', **fraction},
        'arm[fast]': {'type': 'geometric::RRT', 'goal_bias': 0.1, **fraction},
        'hand': {'type': 'geometric::RRTConnect'}}


def test_pipelines_of_ompl_have_their_own_configurations():
    """
    Each pipeline reads the settings in its own namespace.

    Upstream: planning_pipeline.cpp, configure; ompl_interface.cpp, loadPlannerConfigurations.
    """
    def pipeline(planner, fraction):
        return PipelineSettings(
            planner_configs={'mine': {'type': f'geometric::{planner}'}},
            groups={'arm': {'default_planner_config': 'mine',
                            'longest_valid_segment_fraction': fraction}})

    names = ('quick', 'thorough')
    settings = settings_from_config(
        PlanningParameters(planning_pipelines=names),
        {'quick': pipeline('RRTConnect', 0.05), 'thorough': pipeline('RRTstar', 0.005)}, {})
    assert [settings.pipelines[name].planners.configs['arm'] for name in names] == [
        {'type': 'geometric::RRTConnect', 'longest_valid_segment_fraction': 0.05},
        {'type': 'geometric::RRTstar', 'longest_valid_segment_fraction': 0.005}]


@pytest.mark.parametrize(('seeds', 'expected'), [
    ({'ompl': 0, 'quick': 7}, 0), ({'ompl': -1, 'quick': 7}, 7), ({'ompl': -1}, -1),
    ({'ompl': -1, 'unlisted': 7}, -1)])
def test_the_seed_of_all_pipelines(seeds, expected):
    """That of ``ompl``, which the argument ``seed`` sets, else of the first listed with one."""
    settings = settings_from_config(
        PlanningParameters(planning_pipelines=('ompl', 'quick')),
        {name: PipelineSettings(planning_seed=seed) for name, seed in seeds.items()}, {})
    assert settings.seed == expected
