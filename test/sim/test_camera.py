# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where cameras sit and how they see."""

import numpy as np
from pydantic import ValidationError
import pytest

from armsim_ros.cli.arguments import parse_arguments
from armsim_ros.cli.settings import cell_of
from armsim_ros.config.simulation import CameraSettings
from armsim_ros.errors import SimulationError
from armsim_ros.sim.camera import cameras_of


@pytest.fixture(scope='module')
def sunday():
    """Return the robot whose URDF has the frames of a camera."""
    return cell_of(parse_arguments(['robot:=sunday']))[0]


def camera_of(sunday, name='camera', **settings):
    """Return one camera of it."""
    return cameras_of({name: CameraSettings(**settings)}, sunday.model)[0]


def test_the_focal_length_scales_with_the_height(sunday):
    """It is 1043.99 pixels at 1080 lines, and so much less at 480."""
    own = sunday.settings.simulation.cameras['camera']
    lines = {height: own.model_copy(update={'height': height}) for height in (1080, 480)}
    focal = {height: cameras_of({'camera': one}, sunday.model)[0].focal
             for height, one in lines.items()}
    assert focal[1080] == pytest.approx(1043.99, abs=0.005)
    assert focal[480] == pytest.approx(1043.99 * 480 / 1080, abs=0.005)


def test_frames_of_the_urdf_are_taken(sunday):
    """No transform is published twice."""
    camera = camera_of(sunday)
    assert camera.optical_frame == 'camera_color_optical_frame'
    assert camera.body == 'sunday/camera_color_optical_frame'
    assert camera.transforms == ()


def test_a_camera_elsewhere_brings_its_frames(sunday):
    """Where x of the camera looks, z of the optical frame does, and x of that to the right."""
    camera = camera_of(
        sunday, 'front', link='base_link', xyz=(1.0, 0.0, 0.5), rpy=(0.0, 0.0, np.pi))
    (parent, link, body), (again, optical, turn) = camera.transforms
    assert (parent, link, again, optical) == (
        'base_link', 'front_link', 'front_link', 'front_color_optical_frame')
    np.testing.assert_allclose(body[:3, 3], (1.0, 0.0, 0.5), atol=1e-12)
    np.testing.assert_allclose(body @ turn, camera.optical_pose, atol=1e-12)
    np.testing.assert_allclose(camera.optical_pose[:3, 2], (-1.0, 0.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(camera.optical_pose[:3, 0], (0.0, 1.0, 0.0), atol=1e-12)


def test_a_camera_may_stand_in_the_world(sunday):
    """The frame of the model is the world."""
    camera = camera_of(sunday, 'front', link='world', xyz=(1.0, 0.0, 2.0))
    assert camera.body.rpartition('/')[2] == 'world'


@pytest.mark.parametrize(('name', 'settings', 'text'), [
    ('front', {}, "has no link 'front_color_optical_frame'; give with 'link'"),
    ('front', {'link': 'link_55'}, "'link_55', which is not a link .*'link_5'"),
    ('front', {'link': 'map'},
     "'map', which is not a link .*virtual_joint with this parent_frame"),
    ('camera', {'link': 'link_5'}, "has the link 'camera_link' already; leave 'link' out"),
])
def test_a_camera_that_cannot_sit_there_is_refused(sunday, name, settings, text):
    """The message says what to write."""
    with pytest.raises(SimulationError, match=text):
        camera_of(sunday, name, **settings)


@pytest.mark.parametrize('wrong', [
    {'rate': 31}, {'width': 8}, {'range': (1.0, 0.5)}, {'focal_length': 0.0},
    {'xyz': (float('nan'), 0.0, 0.0)},
])
def test_impossible_settings_are_refused(wrong):
    """They are refused before anything is built."""
    with pytest.raises(ValidationError):
        CameraSettings(**wrong)
