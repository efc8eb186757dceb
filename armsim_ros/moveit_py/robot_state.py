# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.core.robot_state``: positions, velocities and poses of a robot."""

from __future__ import annotations

from collections.abc import Mapping
import math
import time
from types import MappingProxyType
from typing import Any, cast, overload, TypeVar

from geometry_msgs.msg import Pose
from moveit_msgs.msg import RobotState as RobotStateMessage
import numpy as np
from numpy.typing import ArrayLike

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import PlanningError
from armsim_ros.kinematics.inverse import IKOptions, IKTarget
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.moveit_py.robot_model import JointModelGroup, RobotModel
from armsim_ros.moveit_py.utils import logger
from armsim_ros.nodes.conversions.geometry import pose_from_message, pose_to_message
from armsim_ros.nodes.conversions.motion_plan_request import robot_state_to_message
from armsim_ros.planning.queries import DEFAULT_IK_TIMEOUT
from armsim_ros.planning.scene.objects import AttachedObject
from armsim_ros.planning.scene.planning_scene import PlanningScene

Self = TypeVar('Self', bound='RobotState')
_KINDS = ('all', 'links_only', 'collisions_only')


class RobotState:
    """
    Positions, velocities, accelerations and efforts of all joints, and what the robot carries.

    Poses are those of the present positions always; ``update`` need not be called for that.

    :param robot_model: the robot; every joint is at its default position.
    """

    def __init__(self, robot_model: RobotModel) -> None:
        self._model = robot_model
        self._q: Vector = robot_model._kinematics.default()
        self._rates = {kind: np.zeros(len(self._q))
                       for kind in ('velocities', 'accelerations', 'efforts')}
        self._attached: Mapping[str, AttachedObject] = MappingProxyType({})
        self._dirty = True

    def __copy__(self) -> RobotState:
        """Return a state of its own with the same values."""
        made = RobotState(self._model)
        made._take(self)
        return made

    def __deepcopy__(self, memo: dict[int, Any]) -> RobotState:
        """Return a state of its own with the same values."""
        return self.__copy__()

    def _take(self, other: RobotState) -> None:
        self._q = other._q.copy()
        self._rates = {kind: values.copy() for kind, values in other._rates.items()}
        self._attached, self._dirty = other._attached, other._dirty

    def _set_q(self, q: Vector) -> None:
        """Take positions (n,) in which mimic joints follow already."""
        self._q, self._dirty = q, True

    @property
    def robot_model(self) -> RobotModel:
        """The robot."""
        return self._model

    @property
    def dirty(self) -> bool:
        """Whether the state has changed since the last ``update``."""
        return self._dirty

    def update(self, force: bool = False, type: str = 'all') -> None:  # noqa: A002
        """
        Note that transforms are requested; they are computed when they are read.

        :param force: also where nothing has changed.
        :param type: all, links_only or collisions_only.
        :raises ValueError: for another type.
        """
        if type not in _KINDS:
            raise ValueError(f"'{type}' is not a type of update; allowed: {', '.join(_KINDS)}")
        if type == 'all' or force:
            self._dirty = False

    # ---------------------------------------------------------------- values of joints

    @property
    def joint_positions(self) -> dict[str, float]:
        """Position of each joint [rad or m]; the joints that a new value names change."""
        return self._model._kinematics.positions(self._q)

    @joint_positions.setter
    def joint_positions(self, values: Mapping[str, float]) -> None:
        self._set_q(self._model._kinematics.vector(values, self._q))

    @property
    def joint_velocities(self) -> dict[str, float]:
        """Velocity of each joint [rad/s or m/s]; the joints that a new value names change."""
        return self._rates_of('velocities')

    @joint_velocities.setter
    def joint_velocities(self, values: Mapping[str, float]) -> None:
        self._set_rates('velocities', values)

    @property
    def joint_accelerations(self) -> dict[str, float]:
        """Acceleration of each joint [rad/s^2 or m/s^2], set like positions."""
        return self._rates_of('accelerations')

    @joint_accelerations.setter
    def joint_accelerations(self, values: Mapping[str, float]) -> None:
        self._set_rates('accelerations', values)

    @property
    def joint_efforts(self) -> dict[str, float]:
        """Effort of each joint [N*m or N], set like positions."""
        return self._rates_of('efforts')

    @joint_efforts.setter
    def joint_efforts(self, values: Mapping[str, float]) -> None:
        self._set_rates('efforts', values)

    def _rates_of(self, kind: str) -> dict[str, float]:
        return self._model._kinematics.positions(self._rates[kind])

    def _set_rates(self, kind: str, values: Mapping[str, float]) -> None:
        for name, value in values.items():
            self._rates[kind][self._model._kinematics.index(name)] = value

    # ---------------------------------------------------------------- values of groups

    def get_joint_group_positions(self, joint_model_group_name: str) -> Vector:
        """Return the positions (v,) of a group [rad or m], of mimic joints too."""
        return self._group(joint_model_group_name)._of(self._q)

    def get_joint_group_velocities(self, joint_model_group_name: str) -> Vector:
        """Return the velocities (v,) of a group [rad/s or m/s]."""
        return self._group(joint_model_group_name)._of(self._rates['velocities'])

    def get_joint_group_accelerations(self, joint_model_group_name: str) -> Vector:
        """Return the accelerations (v,) of a group [rad/s^2 or m/s^2]."""
        return self._group(joint_model_group_name)._of(self._rates['accelerations'])

    def set_joint_group_positions(
        self, joint_model_group_name: str, position_values: ArrayLike
    ) -> None:
        """
        Set the positions of a group.

        :param position_values: (v,) [rad or m] of all its movable joints; mimic joints follow.
        :raises ValueError: values for more or fewer joints.
        """
        q, group = self._q.copy(), self._group(joint_model_group_name)
        q[group._indices] = group._checked(group._variables, position_values)
        self._set_q(self._model._kinematics.apply_mimic(q))

    def set_joint_group_active_positions(
        self, joint_model_group_name: str, position_values: ArrayLike
    ) -> None:
        """
        Set the positions of the joints of a group that do not follow others.

        :param position_values: (m,) [rad or m].
        :raises ValueError: values for more or fewer joints.
        """
        group = self._group(joint_model_group_name)
        values = group._checked(group.active_joint_model_names, position_values)
        self._set_q(self._model._kinematics.insert(self._q, group.name, values))

    def set_joint_group_velocities(
        self, joint_model_group_name: str, velocity_values: ArrayLike
    ) -> None:
        """Set the velocities (v,) of a group [rad/s or m/s]."""
        self._set_group_rates('velocities', joint_model_group_name, velocity_values)

    def set_joint_group_accelerations(
        self, joint_model_group_name: str, acceleration_values: ArrayLike
    ) -> None:
        """Set the accelerations (v,) of a group [rad/s^2 or m/s^2]."""
        self._set_group_rates('accelerations', joint_model_group_name, acceleration_values)

    def _set_group_rates(self, kind: str, name: str, values: ArrayLike) -> None:
        group = self._group(name)
        self._rates[kind][group._indices] = group._checked(group._variables, values)

    def _group(self, name: str) -> JointModelGroup:
        return self._model.get_joint_model_group(name)

    # ---------------------------------------------------------------- poses

    def get_global_link_transform(self, link_name: str) -> Matrix:
        """
        Return the pose (4, 4) of a link in the model frame.

        :raises PlanningError: the robot has no such link.
        """
        return self._model._kinematics.link_pose(self._q, link_name)

    def get_pose(self, link_name: str) -> Pose:
        """Return the pose of a link in the model frame."""
        return pose_to_message(self.get_global_link_transform(link_name))

    def get_frame_transform(self, frame_id: str) -> Matrix:
        """
        Return the pose (4, 4) of a link, an attached object or its subframe.

        :raises PlanningError: there is no such frame.
        """
        return self._scene().frame_pose(frame_id)

    def _scene(self) -> PlanningScene:
        """Return a scene with this state and nothing else."""
        scene = PlanningScene(self._model._kinematics)
        return with_state(scene, self)

    @overload
    def get_jacobian(
        self, joint_model_group_name: str, reference_point_position: ArrayLike) -> Matrix: ...

    @overload
    def get_jacobian(
        self, joint_model_group_name: str, link_name: str, reference_point_position: ArrayLike,
        use_quaternion_representation: bool = False) -> Matrix: ...

    def get_jacobian(  # type: ignore[misc] # an argument has several names
        self, joint_model_group_name: str, link_name: Any = None,
        reference_point_position: Any = None, use_quaternion_representation: bool = False,
    ) -> Matrix:
        """
        Return the Jacobian (6, m) of a point of a link, in the axes of the group's base link.

        :param link_name: the last link of the group where it is not given.
        :param reference_point_position: (3,) [m] in the link's frame.
        :param use_quaternion_representation: (7, m); the last four rows are the rates of the
            quaternion w, x, y, z.
        :raises ValueError: the group is not a chain.
        """
        kinematics, group = self._model._kinematics, self._group(joint_model_group_name)
        if not isinstance(link_name, str) and link_name is not None:
            link_name, reference_point_position = None, link_name
        if not kinematics.is_chain(group.name):
            raise ValueError(f"group '{group.name}' is not a chain; only chains have a Jacobian")
        link = group.link_model_names[-1] if link_name is None else link_name
        base = kinematics.robot.joints[group.joint_model_names[0]].parent
        pose = kinematics.link_pose(self._q, link)
        axes = kinematics.link_pose(self._q, base)[:3, :3].T
        jacobian = kinematics.jacobian(self._q, link, group.name)
        point = pose[:3, :3] @ np.asarray(reference_point_position, dtype=np.float64).ravel()
        linear = jacobian[:3] + np.cross(jacobian[3:].T, point).T
        rows = [axes @ linear, axes @ jacobian[3:]]
        if use_quaternion_representation:
            turned = np.eye(4)
            turned[:3, :3] = axes @ pose[:3, :3]
            x, y, z, w = quat_xyzw_from_matrix(turned)
            rates = np.array([[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]])
            rows[1] = 0.5 * rates @ rows[1]
        return cast(Matrix, np.concatenate(rows))

    # ---------------------------------------------------------------- whole states

    def set_from_ik(
        self, joint_model_group_name: str, geometry_pose: Pose, tip_name: str, timeout: float = 0.0
    ) -> bool:
        """
        Set a group so that a frame has a pose; the search begins at this state.

        :param geometry_pose: in the model frame.
        :param tip_name: the tip of the group's solver, or what is fixed to it: a link, an object
            that the robot carries, or its subframe.
        :param timeout: [s]; 0 for that of kinematics.yaml.
        :returns: False where no solution was found, or the solver cannot position the frame; the
            state is as it was.
        """
        model, name = self._model, self._group(joint_model_group_name).name
        pose = pose_from_message(geometry_pose)
        with model._lock:
            context = model._context
            try:
                frame = context.solver_target(self._scene(), name, tip_name)
                inverse = context.inverse(name)
            except PlanningError as error:
                logger().error(f'set_from_ik: {error}')
                return False
            seconds = timeout or max(
                DEFAULT_IK_TIMEOUT, context.settings.ik_timeouts.get(name, 0.0))
            targets = [IKTarget(frame.link, pose, frame.offset)]
            inverse.prepare(targets)
            found = inverse.solve(targets, self._q, IKOptions(
                clock=time.monotonic, deadline=time.monotonic() + seconds))
        if found.q is None:
            logger().warning(f'set_from_ik: {found.message}')
            return False
        self._set_q(found.q)
        return True

    @overload
    def set_to_default_values(self) -> None: ...

    @overload
    def set_to_default_values(self, joint_model_group: JointModelGroup, name: str) -> bool: ...

    @overload
    def set_to_default_values(self, joint_model_group_name: str, name: str) -> bool: ...

    def set_to_default_values(  # type: ignore[misc] # an argument has several names
        self, joint_model_group: Any = None, name: Any = None, joint_model_group_name: Any = None,
    ) -> bool | None:
        """
        Set all joints to their defaults and at rest, or a group to a named state of the SRDF.

        :returns: of a group, whether there is such a state.
        """
        kinematics = self._model._kinematics
        which = joint_model_group if joint_model_group_name is None else joint_model_group_name
        if which is None:
            self._set_q(kinematics.default())
            for rates in self._rates.values():
                rates[:] = 0.0
            return None
        group = which if isinstance(which, JointModelGroup) else self._group(which)
        states = kinematics.robot.semantic.named_states.get(group.name, {})
        if name not in states:
            logger().error(self._model._unknown_state(group.name, name))
            return False
        self._set_q(kinematics.vector(states[name], self._q))
        return True

    def set_to_random_positions(self, joint_model_group: JointModelGroup | None = None) -> None:
        """
        Set the joints of a group, or all, to random positions within their bounds.

        Joints without bounds get an angle from -pi to pi.
        """
        kinematics, q = self._model._kinematics, self._q.copy()
        places = slice(None) if joint_model_group is None else joint_model_group._indices
        low = np.where(np.isfinite(kinematics.lower), kinematics.lower, -math.pi)
        high = np.where(np.isfinite(kinematics.upper), kinematics.upper, math.pi)
        q[places] = np.random.default_rng().uniform(low, high)[places]
        self._set_q(kinematics.apply_mimic(q))

    def clear_attached_bodies(self) -> None:
        """Drop all that the robot carries."""
        self._attached = MappingProxyType({})

    @property
    def state_tree(self) -> str:
        """The links with their poses, a line per link."""
        return ''.join(
            f'{link}: {np.array2string(self.get_global_link_transform(link)[:3], precision=4)}\n'
            for link in self._model._kinematics.robot.links)

    @property
    def state_info(self) -> str:
        """The joints with their positions and velocities, a line per joint."""
        velocities = self.joint_velocities
        return ''.join(f'{joint}: position {value:g}, velocity {velocities[joint]:g}\n'
                       for joint, value in self.joint_positions.items())


def with_state(scene: PlanningScene, state: RobotState) -> PlanningScene:
    """Return a scene in which the robot has a state and carries what it carries."""
    if scene.q is state._q and scene.attached is state._attached:
        return scene
    return scene.with_robot(state._q, state._attached)


def robotStateToRobotStateMsg(
    state: RobotState, copy_attached_bodies: bool = True
) -> RobotStateMessage:
    """Return the message of a state, with the objects that the robot carries unless refused."""
    message = robot_state_to_message(
        state.joint_positions, state.robot_model.model_frame,
        attached=state._attached.values() if copy_attached_bodies else ())
    velocities = state._rates['velocities']
    if velocities.any():
        message.joint_state.velocity = velocities.tolist()
    return message
