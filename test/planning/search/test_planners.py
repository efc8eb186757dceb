# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the way from a planner's name to a planner."""

import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.planning.search.planners import PLANNER_TYPES, PlannerTable

MOVEIT_TYPES = (
    'AnytimePathShortening', 'BFMT', 'BiEST', 'BiTRRT', 'BKPIECE', 'EST', 'FMT', 'KPIECE',
    'LazyPRM', 'LazyPRMstar', 'LazyRRT', 'LBKPIECE', 'LBTRRT', 'PDST', 'PRM', 'PRMstar',
    'ProjEST', 'RRT', 'RRTConnect', 'RRTstar', 'SBL', 'SPARS', 'SPARStwo', 'STRIDE', 'TRRT',
)

TABLE = PlannerTable(
    {
        'fast': {'type': 'geometric::RRTConnect', 'range': 0.3},
        'arm[fast]': {'type': 'geometric::RRT', 'goal_bias': 0.1},
        'star': {'type': 'geometric::RRTstar'},
        'odd': {'type': 'geometric::Nothing'},
    },
    {'arm': 'star'},
)


@pytest.mark.parametrize('name', MOVEIT_TYPES)
def test_every_type_is_understood(name, log):
    """OMP-1: all 25 planner types lead to a planner."""
    assert PlannerTable({'x': {'type': f'geometric::{name}'}}).choose('x', 'arm', log).type \
        in PLANNER_TYPES


def test_a_type_that_is_not_bound_is_replaced_with_a_warning(log):
    """OMP-1: a planner that OMPL's Python package lacks gives the nearest one, and says so."""
    assert PlannerTable().choose('EST', 'arm', log).type == 'KPIECE'
    assert 'using geometric::KPIECE' in log.recorder.text()


def test_the_groups_own_configuration_first(log):
    """REQ-3: ``group[id]`` goes before ``id``."""
    assert TABLE.choose('fast', 'arm', log).type == 'RRT'
    assert TABLE.choose('fast', 'other', log).type == 'RRTConnect'


def test_id_with_brackets(log):
    """RVZ-5: ids of the form ``group[planner]`` are read."""
    assert TABLE.choose('arm[fast]', 'arm', log).parameters['goal_bias'] == 0.1


def test_empty_id_is_the_groups_default(log):
    """REQ-3: an empty id means the group's default configuration, else RRTConnect."""
    assert TABLE.choose('', 'arm', log).type == 'RRTstar'
    assert TABLE.choose('', 'other', log).type == 'RRTConnect'
    assert not log.recorder.lines


def test_unknown_id_is_the_default_with_a_warning(log):
    """REQ-3: an unknown id is no error."""
    assert TABLE.choose('fsat', 'arm', log).type == 'RRTstar'
    assert "'fsat' is not known" in log.recorder.text()
    assert "did you mean 'fast'" in log.recorder.text()


def test_ros1_ids(log):
    """REQ-3: ``RRTConnectkConfigDefault`` means RRTConnect where it is not configured."""
    assert PlannerTable().choose('RRTstarkConfigDefault', 'arm', log).type == 'RRTstar'
    assert not log.recorder.lines


def test_unknown_type_is_an_error(log):
    """OMP-1: a configuration with an unknown type cannot be used."""
    with pytest.raises(PlanningError, match="unknown type 'geometric::Nothing'") as caught:
        TABLE.choose('odd', 'arm', log)
    assert caught.value.code == -1


def test_ids_for_clients():
    """OMP-8: configurations alone, with their group in brackets, and the group's name."""
    ids = TABLE.planner_ids(('arm',))
    assert {'fast', 'arm[fast]', 'arm'} <= set(ids)
