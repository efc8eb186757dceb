# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parts of ``<ros2_control>`` tags, and what becomes of a package with them."""

from armsim_ros.errors import Severity
from armsim_ros.model.cell_loading import survey_cell
from armsim_ros.sim.assembly import build_managers, build_simulation

STATES = '<state_interface name="position">{0}</state_interface><state_interface name="velocity"/>'
INITIAL = '<param name="initial_value">{0}</param>'


def joint(name, *commands, states=None, inside='', words=''):
    """Return a joint of the tag."""
    return (f'<joint name="{name}" {words}>'
            + ''.join(f'<command_interface name="{one}"/>' for one in commands)
            + (STATES.format('') if states is None else states) + inside + '</joint>')


def start(package, **words):
    """Return simulation, manager and messages of a package."""
    survey = survey_cell(str(package.folder), **words)
    cell = survey.checked()
    simulation = build_simulation(cell.settings, cell.model)
    (manager,) = build_managers(cell, simulation).values()
    return simulation, manager, survey.problems


def said(problems, severity=Severity.WARNING):
    """Return the messages of one kind."""
    return [str(one) for one in problems if one.severity is severity]


def mistakes(package, **words):
    """Return the mistakes of a package."""
    return said(survey_cell(str(package.folder), **words).problems, Severity.ERROR)
