# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Streams of servo without ROS and without time, and what came of them."""

import numpy as np

from armsim_ros.config.servo import ServoNodeSettings, ServoParameters
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.servo.assembly import build_stream
from armsim_ros.servo.commands import JointJog, Twist

GROUP = 'manipulator'
ELBOW_UP = (0.0, 0.3, 1.5, 0.5, 1.0, 0.0)


class Streamer:
    """A stream and what came of it."""

    def __init__(self, kinematics, start=ELBOW_UP, group=GROUP, **parameters):
        servo = {key: parameters.pop(key) for key in ('butterworth_filter_coeff', 'update_period')
                 if key in parameters}
        self.kinematics, self.group = kinematics, group
        self.settings = ServoNodeSettings(moveit_servo=ServoParameters(**parameters), **servo)
        self.parameters = self.settings.moveit_servo
        self.scene = PlanningScene(kinematics)
        self.checker = CollisionChecker(self.scene)
        self.stream, self.warnings = build_stream(
            kinematics, self.scene, self.checker, self.settings, group
        )
        self.stream.start(np.array(start, float))
        self.positions = [np.array(start, float)]
        self.cycles = []

    @property
    def q(self):
        """The whole robot where the stream is."""
        return self.kinematics.insert(self.kinematics.default(), self.group, self.positions[-1])

    @property
    def tip(self):
        """Pose of the tip."""
        return self.kinematics.link_pose(self.q, self.stream.target.tip)

    def run(self, command, seconds):
        """Follow a command; return the cycles."""
        count = round(seconds / self.parameters.publish_period)
        for _ in range(count):
            cycle = self.stream.step(command, self.q, self.parameters)
            self.positions.append(cycle.positions)
            self.cycles.append(cycle)
        return self.cycles[-count:]

    def codes(self):
        """Return all codes that were told."""
        return {finding.code for cycle in self.cycles for finding in cycle.findings}

    def add_box(self, name, size, xyz):
        """Put a box into the scene."""
        self.scene.apply_object(CollisionObject(
            name, pose=pose_matrix(xyz), shapes=(ObjectShape(Box(size), np.eye(4)),)))

    def steps(self):
        """Return the largest step of each joint, and the largest change of it."""
        steps = np.diff(self.positions, axis=0)
        return np.abs(steps).max(axis=0), np.abs(np.diff(steps, axis=0)).max(axis=0)


def twist(linear=(0, 0, 0), angular=(0, 0, 0), frame='base_link'):
    """Return a twist."""
    return Twist(frame, np.array(linear, float), np.array(angular, float))


def jog(**velocities):
    """Return a joint jog."""
    return JointJog(tuple(velocities), np.array(list(velocities.values()), float))
