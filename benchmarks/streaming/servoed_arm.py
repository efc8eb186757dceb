# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An arm that is streamed to without ROS: servo's cycles beside the control loop, in lockstep."""

from __future__ import annotations

from collections.abc import Iterator

from armsim_ros.arrays import Vector
from armsim_ros.config.servo import ServoNodeSettings, ServoParameters
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.servo.assembly import arm_group, build_stream
from armsim_ros.servo.commands import Command
from armsim_ros.servo.stream import Cycle
from armsim_ros.servo.trajectory_window import TrajectoryWindow
from armsim_ros.stack import ArmSim

#: Points that have been sent are followed for so long after the stream has come to rest [s].
_DRAINING = 0.2


class ServoedArm:
    """
    A simulated arm, its trajectory controller and a stream to it.

    :param sim: one robot.
    :param parameters: of servo, other than its defaults.
    """

    def __init__(self, sim: ArmSim, **parameters: object) -> None:
        self.sim = sim
        self.kinematics = sim.scene.kinematic_model
        self.parameters = ServoParameters.model_validate(parameters)
        self.controller = next(
            one for one in sim.manager.controllers.values()
            if isinstance(one, JointTrajectoryController))
        self.group = arm_group(self.kinematics, [self.controller.joints])
        self.stream, _ = build_stream(
            self.kinematics, sim.scene, CollisionChecker(sim.scene),
            ServoNodeSettings(moveit_servo=self.parameters), self.group,
        )
        self._window = TrajectoryWindow(
            self.stream.target.names, round(self.parameters.max_expected_latency * 1e9))
        self._steps = round(self.parameters.publish_period * 1e9 / sim.simulation.clock.step_ns)

    @property
    def q(self) -> Vector:
        """The robot's state (n,) [rad or m]."""
        return self.kinematics.vector(self.sim.joint_positions)

    def start(self) -> None:
        """Begin where the controller's reference is."""
        snapshot = self.controller.snapshot()
        if snapshot is None:
            raise RuntimeError('the trajectory controller has never been active')
        order = [snapshot.joint_names.index(name) for name in self.stream.target.names]
        reference = snapshot.reference.positions[order]
        self.stream.start(reference)
        self._window.start(self.sim.simulation.time_ns, self.stream.state)

    def cycle(self, command: Command | None) -> Cycle:
        """Do one cycle of servo, hand what it brings to the controller, go on by a period."""
        def step() -> Cycle:
            return self.stream.step(command, self.q, self.parameters)

        now = self.sim.simulation.time_ns
        if self.stream.turns(command):
            self._window.replan(
                now, now, round(self.parameters.publish_period * 1e9), self.stream, step)
        made = step()
        self._window.add(now, self.stream.state)
        trajectory = self._window.trajectory()
        if trajectory is not None:
            reason = self.controller.set_trajectory(trajectory)
            if reason:
                raise RuntimeError(f'the controller drops what servo sends: {reason}')
        self.sim.step(self._steps)
        return made

    def follow(self, command: Command | None, seconds: float) -> Iterator[Cycle]:
        """Follow a command for so long; yields each cycle."""
        for _ in range(round(seconds / self.parameters.publish_period)):
            yield self.cycle(command)

    def come_to_rest(self) -> Iterator[Cycle]:
        """Do cycles without a command until stream and arm rest; yields each cycle."""
        left = _DRAINING
        while left > 0:
            made = self.cycle(None)
            left = left - self.parameters.publish_period if made.at_rest else _DRAINING
            yield made


def touched(sim: ArmSim, links: frozenset[str]) -> set[tuple[str, str]]:
    """
    Return what touches one of some links now, as sorted pairs of bodies.

    :param links: names of bodies, ``robot/link``.
    """
    bodies, overlaps = sim.simulation.touching()
    names = sim.simulation.body_names
    pairs = {(names[first], names[second]) for (first, second), depth
             in zip(bodies, overlaps, strict=True) if depth > 0.0}
    return {(min(pair), max(pair)) for pair in pairs if links & set(pair)}


def moving_links(sim: ArmSim) -> frozenset[str]:
    """Return the bodies that joints of the robot move, as ``robot/link``."""
    model, moved = sim.model, set()
    for joint in model.joints.values():
        if joint.movable or joint.parent in moved:
            moved.add(joint.child)
    return frozenset(f'{model.name}/{link}' for link in moved)
