# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the proof that a motion is free between the states that are looked at."""

import numpy as np
import pytest
from small_arms import serial_arm

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.collision.motion_proof import first_blocked
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.scene.planning_scene import PlanningScene

STEP = 0.01


@pytest.fixture
def validity(planar_scene, log):
    """Return what judges the planar arm's states; boxes may be added before."""
    return PlanningContext(planar_scene, log=log).validity(planar_scene, 'arm')


def test_free_motion(validity):
    """A motion far from everything is free."""
    assert first_blocked(np.array([[0.0, 0.2, 0.2], [1.0, 0.4, 0.1]]), validity, STEP) is None


def test_a_robot_without_shapes_is_free(log):
    """Nothing blocks the motion of links that have no geometry."""
    arm = serial_arm('bare', [((0.0, 0.0, 0.1), (0.0, 0.0, 0.0), np.array([0.0, 0.0, 1.0]))])
    scene = PlanningScene(KinematicModel(arm))
    validity = PlanningContext(scene, log=log).validity(scene, 'arm')
    assert first_blocked(np.array([[0.0], [1.0]]), validity, STEP) is None


def test_no_motion(validity):
    """A single state, or none, is no motion."""
    assert first_blocked(np.zeros((1, 3)), validity, STEP) is None
    assert first_blocked(np.zeros((0, 3)), validity, STEP) is None


@pytest.mark.parametrize('thickness', [0.01, 0.001, 0.0001])
def test_a_thin_plate_is_not_jumped_over(planar_scene, add_box, validity, thickness):
    """However thin an object is, a motion through it is found."""
    add_box(planar_scene, 'plate', (0.3, thickness, 0.3), (0.8, 0.3, 0.0))
    line = np.array([[0.0, 0.0, 0.0], [0.9, 0.0, 0.0]])
    place = first_blocked(line, validity, STEP)
    assert place is not None
    assert not validity.free(line[0] + place * (line[1] - line[0]))


def test_place_of_what_blocks(planar_scene, add_box, validity):
    """What is returned is a place where the motion is blocked, in the caller's own measure."""
    add_box(planar_scene, 'post', (0.02, 0.02, 0.3), (0.38, 0.38, 0.0))
    points = np.array([[a, 0.0, 0.0] for a in np.linspace(0.0, 1.5, 20)])
    times = np.linspace(3.0, 5.0, 20)
    place = first_blocked(points, validity, STEP, times)
    assert 3.0 < place < 5.0
    angle = float(np.interp(place, times, points[:, 0]))
    assert not validity.free(np.array([angle, 0.0, 0.0]))


def test_close_by_is_free_and_without_clearance_is_not(planar_scene, add_box, validity):
    """A motion past an object at half a millimetre is free, but leaves no clearance of one."""
    # The last link's box ends at 0.4 + 0.3 + 0.16 m from the base; its corner is 0.02 m aside.
    reach = float(np.hypot(0.86, 0.02))
    add_box(planar_scene, 'near', (0.1, 0.02, 0.1), (reach + 0.0505, 0.0, 0.0))
    line = np.array([[-0.4, 0.0, 0.0], [0.4, 0.0, 0.0]])
    assert first_blocked(line, validity, STEP) is None
    assert first_blocked(line, validity, STEP, clearance=0.001) is not None


def test_the_arm_itself_is_met(validity):
    """A motion that folds the arm into itself is found."""
    line = np.array([[0.0, 0.0, 0.0], [0.0, 2.8, 2.8]])
    assert (first_blocked(line, validity, STEP) is None) == all(
        validity.free(line[0] + part * (line[1] - line[0])) for part in np.linspace(0, 1, 2000))
