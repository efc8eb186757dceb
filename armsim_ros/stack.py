# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The whole stack without ROS: robot, physics, controllers and planning, moved step by step."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.control.arm_state import Cause
from armsim_ros.control.command_controllers.gripper_controller import GripperGoal
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.control.trajectory.goal import TrajectoryGoal
from armsim_ros.errors import ControllerError, PlanningError, SimulationError
from armsim_ros.model.cell import Cell
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.model.grippers import grippers_in
from armsim_ros.model.world_objects import world_in_root, WorldObject
from armsim_ros.planning.budget import CountingClock
from armsim_ros.sim.assembly import build_control, build_manager, build_simulation
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.finger_contacts import FingerContacts
from armsim_ros.trajectory import JointTrajectory

if TYPE_CHECKING:
    from armsim_ros.execution.in_process import SentGoal
    from armsim_ros.planning.planner import MotionPlanner
    from armsim_ros.planning.request import Constraints
    from armsim_ros.planning.scene.planning_scene import PlanningScene
    from armsim_ros.simulation_in_scene import CameraInScene, WorldInScene

__all__ = ['ArmSim', 'build_manager', 'build_simulation']

Goal: TypeAlias = 'str | Mapping[str, float] | Matrix | Constraints'


class ArmSim:
    """
    A robot with its controllers and its planner, in simulated time that only ``step`` moves.

    No wall clock is read: the same seed and the same calls give the same ``digest``. A cell of
    several robots is moved the same way: a single world and planner, a manager per robot.

    :param robot: a name under ``config/``, or a path to a folder with the user's files, of a
        robot or of a cell; or what ``load_cell`` returned, which many can share.
    :param seed: of the planner's random numbers.
    :param world: a world's name or file in place of the robot's own.
    :param overrides: dotted path -> value over the files, such as
        ``{'simulation.gravity': [0, 0, 0]}``. This and ``world`` are for files to be read.
    :raises ConfigError: the files do not describe a robot that can run.
    """

    def __init__(
        self, robot: str | Path | Cell = 'sunday', *, seed: int = 0,
        world: str | Path | None = None, overrides: Mapping[str, object] | None = None
    ) -> None:
        self.seed = seed
        if not isinstance(robot, Cell):
            robot = load_cell(str(robot), world=world, overrides=overrides)
        self.cell = robot
        self.settings, self.model = self.cell.settings, self.cell.model
        self.simulation = build_simulation(self.settings, self.model)
        self.managers, controllers, self.faults = build_control(self.cell, self.simulation)
        rate = self.settings.controller_manager.update_rate
        self.loop = ControlLoop(self.simulation, controllers, rate)
        self._planning_clock = CountingClock()
        self._shared_objects: set[str] = set()

    def begin(self, positions: Mapping[str, float], poses: Mapping[str, Matrix], *,
              seed: int = 0) -> None:
        """
        Begin anew at time 0; the planner forgets what it knew.

        :param positions: joint -> start [rad or m]; the others start as usual.
        :param poses: free object -> where it is, (4, 4) in the world.
        :param seed: of the planner's random numbers.
        :raises SimulationError: a joint or an object that is not there.
        """
        self.seed = seed
        self._planning_clock = CountingClock()
        for part in ('fingers', 'scene', 'planner', '_world_in_scene'):
            vars(self).pop(part, None)
        self.simulation.begin(positions, poses)

    @property
    def manager(self) -> ControllerManager:
        """
        The controller manager of the only robot; ``managers`` has them by robot.

        :raises ControllerError: there are several.
        """
        if len(self.managers) > 1:
            names = ', '.join(f"managers['{name}']" for name in self.managers)
            raise ControllerError(f'each robot has a manager of its own: {names}')
        return next(iter(self.managers.values()))

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.simulation.time_ns * 1e-9

    @property
    def joint_positions(self) -> dict[str, float]:
        """Joint -> measured position [rad or m]."""
        positions = self.simulation.state.position.tolist()
        return dict(zip(self.simulation.joint_names, positions, strict=True))

    def link_pose(self, link: str) -> Matrix:
        """
        Return where a link is, (4, 4) in the model frame.

        :raises PlanningError: there is no such link.
        """
        model = self.scene.kinematic_model
        return model.link_pose(model.vector(self.joint_positions), link)

    def protective_stop(self, cause: str = 'injected') -> None:
        """
        Stop all arms: goals end, the joints brake and are held until ``clear_stop``.

        :param cause: is added to the texts of the goals.
        """
        for manager in self.managers.values():
            manager.arm.time_ns = self.simulation.time_ns
            manager.arm.protective_stop(
                Cause('injected', '' if cause == 'injected' else cause))

    def clear_stop(self) -> None:
        """
        End a protective stop of all arms.

        :raises ControllerError: it goes on; with the reason.
        """
        for manager in self.managers.values():
            manager.arm.time_ns = self.simulation.time_ns
            if reason := manager.arm.clear_stop():
                raise ControllerError(f'the stop is not cleared: {reason}')
            manager.stops.follow(self.simulation.time_ns)

    @property
    def safety(self) -> dict[str, str]:
        """Robot -> state of its safety, such as ``NORMAL`` or ``PROTECTIVE_STOP``."""
        return {name: manager.arm.safety.value for name, manager in self.managers.items()}

    def step(self, count: int = 1) -> None:
        """
        Do physics steps, with the controllers' updates that belong to them.

        :raises SimulationError: the physics became unstable.
        """
        self._advance(count)

    def run_until(self, condition: Callable[[], bool] | float, *, timeout: float = 60.0) -> None:
        """
        Step until a condition holds, or until a simulated time.

        :param condition: checked after each step; or a time [s].
        :param timeout: simulated time to wait for a condition [s].
        :raises SimulationError: the condition was not met in that time.
        """
        if not callable(condition):
            left_ns = round(condition * 1e9) - self.simulation.time_ns
            self.step(max(0, -(-left_ns // self.simulation.clock.step_ns)))
            return
        deadline = self.simulation.time_ns + round(timeout * 1e9)
        while not condition():
            if self.simulation.time_ns >= deadline:
                raise SimulationError(
                    f'the condition was not met within {timeout:g} s of simulated time')
            self.step()

    def plan(
        self, goal: Goal, group: str = '', *, allowed_time: float = 5.0, velocity: float = 1.0
    ) -> JointTrajectory:
        """
        Plan a motion from the measured state.

        :param goal: a named state, joint -> position [rad or m], the pose (4, 4) of the group's
            tip in the model's frame, or constraints.
        :param group: planning group; by default the first.
        :param allowed_time: time for the search [s]; it is counted in reads of the planner's
            clock, so that the result does not depend on the machine.
        :param velocity: share of the velocity limits in 0..1.
        :raises PlanningError: there is no such motion.
        """
        from armsim_ros.planning.request import MotionPlanRequest

        group = group or self.model.semantic.first_group
        request = MotionPlanRequest(
            group_name=group, goal_constraints=(self._constraints(goal, group),),
            allowed_planning_time=allowed_time, max_velocity_scaling_factor=velocity,
            seed=self.seed)
        self.scene.set_positions(self.joint_positions)
        self._follow_world()
        response = self.planner.plan(request, self.scene.snapshot(), clock=self._planning_clock)
        if not response.success:
            raise PlanningError(response.error_code, response.message, response.source)
        return response.trajectory

    def send_trajectory(self, trajectory: JointTrajectory
                        ) -> tuple[TrajectoryGoal | GripperGoal, ...]:
        """
        Give a trajectory to the controllers that have its joints; they start at the next step.

        A gripper gets the last point alone, as from move_group.

        :returns: a goal for each controller.
        :raises ControllerError: no controller has the joints, or a controller rejects its part.
        """
        return tuple(part.goal for part in self._send(trajectory))

    def _send(self, trajectory: JointTrajectory) -> list[SentGoal]:
        from armsim_ros.execution.in_process import send_parts

        return send_parts(
            trajectory, self.model, self.managers, self.settings.moveit_controllers)

    def execute(self, trajectory: JointTrajectory) -> None:
        """
        Run a trajectory to its end.

        :raises ControllerError: a controller rejected or aborted it.
        :raises SimulationError: it does not end, or the physics became unstable.
        """
        sent = self._send(trajectory)
        execution = self.settings.trajectory_execution
        allowed = (
            trajectory.duration * execution.allowed_execution_duration_scaling
            + execution.allowed_goal_duration_margin)
        self._advance(
            round(allowed * 1e9) // self.simulation.clock.step_ns + 1,
            lambda: all(part.goal.done for part in sent))
        for part in sent:
            if not part.goal.done:
                raise SimulationError(
                    f'the trajectory did not end within {allowed:g} s of simulated time')
            if not part.succeeded:
                raise ControllerError(
                    f'the trajectory was {part.goal.status.name.lower()}: {part.failure}')

    @cached_property
    def fingers(self) -> FingerContacts:
        """What the fingers touch."""
        return FingerContacts(self.simulation, grippers_in(self.cell))

    @property
    def held(self) -> dict[str, str]:
        """Object -> link that holds it: between fingers that press it now, or at a cup."""
        held = {name: gripper.palm for name, gripper in self.fingers.squeezed().items()}
        cups = self.simulation.vacuum_grippers.values()
        return held | {cup.held: cup.settings.link for cup in cups if cup.held}

    def add_object(self, item: WorldObject) -> None:
        """
        Put an object into the world that physics and planner share.

        The planner sees it where it is when a plan is asked for; what is held goes with the arm.
        So it sees all objects of the world, unless the settings' ``scene_from_world`` is not
        ``live``: then it sees those that are added here.

        :raises SimulationError: its name is taken, or the physics refuses it.
        :raises PlanningError: the planner refuses it; nothing is added then.
        """
        self.simulation.world.add(item)
        self._shared_objects.add(item.name)
        try:
            self._follow_world()
        except PlanningError:
            self.remove_object(item.name)
            raise

    def remove_object(self, name: str) -> None:
        """
        Take an object out of the world.

        :raises SimulationError: there is none of that name.
        """
        self.simulation.world.remove(name)
        self._shared_objects.discard(name)
        self._follow_world()

    def look(self, camera: str) -> None:
        """
        Add what a camera of simulation.yaml sees now to the octomap of the scene.

        The next plan keeps away from it. Robot, loads and objects that the scene knows are left
        out; so of a scene that follows the world, all is.

        :raises SimulationError: there is no such camera.
        """
        self.scene.set_positions(self.joint_positions)
        self._follow_world()
        self._camera_in_scene.look(camera)

    def _advance(self, steps: int, until: Callable[[], bool] | None = None) -> None:
        self.loop.advance(steps, until)
        for fault in self.loop.poll_faults():
            raise SimulationError(fault)

    def digest(self) -> str:
        """Return a hash of the state of plant, drives and time."""
        return self.simulation.digest()

    @cached_property
    def scene(self) -> PlanningScene:
        """
        What the planner knows of robot and world; objects may be added to it.

        What is the world's follows it when a plan is asked for; what the user adds, moves or
        attaches is left alone.
        """
        from armsim_ros.kinematics.kinematic_model import KinematicModel
        from armsim_ros.kinematics.planning_limits import planning_robot
        from armsim_ros.scene_sources.simulated_world import initial_scene

        settings = self.settings
        model = KinematicModel(planning_robot(self.model, settings.joint_limits))
        return initial_scene(model, settings, settings.planning_parameters)

    @cached_property
    def planner(self) -> MotionPlanner:
        """The motion planner; built when it is first needed."""
        from armsim_ros.planning.context import settings_from_config
        from armsim_ros.planning.planner import MotionPlanner

        settings = self.settings
        return MotionPlanner(
            self.scene,
            settings=settings_from_config(
                settings.planning_parameters, settings.pipelines, settings.kinematics))

    @cached_property
    def _world_in_scene(self) -> WorldInScene:
        from armsim_ros.simulation_in_scene import WorldInScene

        return WorldInScene(
            self.simulation, self.scene, world_in_root(self.settings), self.fingers.squeezed)

    @cached_property
    def _camera_in_scene(self) -> CameraInScene:
        from armsim_ros.simulation_in_scene import CameraInScene

        return CameraInScene(
            self.simulation, self.scene, self.settings.octomap, world_in_root(self.settings))

    def _follow_world(self) -> None:
        live = self.settings.planning_parameters.scene_from_world == 'live'
        self._world_in_scene.follow(None if live else frozenset(self._shared_objects))

    def _constraints(self, goal: Goal, group: str) -> Constraints:
        from armsim_ros.planning.request import Constraints

        if isinstance(goal, str):
            goal = self.model.semantic.named_state(group, goal)
        if isinstance(goal, Constraints):
            return goal
        if isinstance(goal, Mapping):
            return Constraints.of_joints(goal)
        pose = np.asarray(goal, dtype=np.float64)
        return Constraints.of_pose(self.model.group(group).tips[0], pose, self.model.model_frame)
