# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of compliant controllers: of crisp_controllers, and of FZI's cartesian ones."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import ConfigDict, model_validator
from typing_extensions import Self

from armsim_ros.config.base import (
    configured,
    ControllerParameters,
    entry_per_name,
    fixed,
    parameter,
    Settings,
)

_MOST = 5000.0


def _gain(default: float, description: str, least: float = 0.0, most: float = _MOST) -> Any:
    return parameter(default, description, ge=least, le=most)


def _smoothing(default: float, least: float = 0.0) -> Any:
    return parameter(default, 'share of the last value in the smoothed value', ge=least, le=1.0)


class ErrorClipSettings(Settings):
    """The largest error that counts, in each axis."""

    x: float = parameter(0.1, '[m]', ge=0.0)
    y: float = parameter(0.1, '[m]', ge=0.0)
    z: float = parameter(0.1, '[m]', ge=0.0)
    rx: float = parameter(0.5, '[rad]', ge=0.0)
    ry: float = parameter(0.5, '[rad]', ge=0.0)
    rz: float = parameter(0.5, '[rad]', ge=0.0)


class TaskSettings(Settings):
    """Spring and damper of the tip; a damping that is not above 0 is 2 * sqrt(stiffness)."""

    k_pos_x: float = _gain(500.0, 'stiffness [N/m]')
    k_pos_y: float = _gain(500.0, 'stiffness [N/m]')
    k_pos_z: float = _gain(500.0, 'stiffness [N/m]')
    k_rot_x: float = _gain(30.0, 'stiffness [N*m/rad]')
    k_rot_y: float = _gain(30.0, 'stiffness [N*m/rad]')
    k_rot_z: float = _gain(30.0, 'stiffness [N*m/rad]')
    d_pos_x: float = _gain(-1.0, 'damping [N*s/m]', -1.0)
    d_pos_y: float = _gain(-1.0, 'damping [N*s/m]', -1.0)
    d_pos_z: float = _gain(-1.0, 'damping [N*s/m]', -1.0)
    d_rot_x: float = _gain(-1.0, 'damping [N*m*s/rad]', -1.0)
    d_rot_y: float = _gain(-1.0, 'damping [N*m*s/rad]', -1.0)
    d_rot_z: float = _gain(-1.0, 'damping [N*m*s/rad]', -1.0)
    error_clip: ErrorClipSettings = parameter(ErrorClipSettings(), 'the largest error that counts')


class WeightSettings(Settings):
    """A joint's share of the stiffness and damping of the posture."""

    value: float = _gain(1.0, 'weight', most=500.0)


class NullspaceSettings(Settings):
    """What holds the posture, as far as it does not move the tip."""

    stiffness: float = _gain(1.0, 'stiffness [N*m/rad]', most=500.0)
    damping: float = _gain(-1.0, 'damping; below 0, and at 0 of CartesianController, it is '
                           '2 * sqrt(stiffness) [N*m*s/rad]', -1.0, 500.0)
    weights: dict[str, WeightSettings] = parameter({}, 'joint -> weight')
    regularization: float = parameter(1e-6, 'of the inverse of the Jacobian', ge=1e-6, le=1e-4)
    projector_type: Literal['kinematic', 'dynamic', 'none'] = parameter(
        'kinematic', 'what keeps the posture from moving the tip; none controls the joints')
    max_tau: float = parameter(5.0, 'largest torque of a joint [N*m]', ge=0.0)


class SmoothingSettings(Settings):
    """Smoothing in each update."""

    target_pose: float = _smoothing(0.1, 0.1)
    q: float = _smoothing(0.5)
    dq: float = _smoothing(0.5)
    q_ref: float = _smoothing(0.5)
    output_torque: float = _smoothing(0.5)


class FrictionSettings(Settings):
    """Sigmoid of each joint's velocity, fp1 * (s(fp2 * (v + fp3)) - s(fp2 * fp3))."""

    fp1: tuple[float, ...] = parameter(
        (0.54615, 0.87224, 0.64068, 1.2794, 0.83904, 0.30301, 0.56489), '[N*m]')
    fp2: tuple[float, ...] = parameter(
        (5.1181, 9.0657, 10.136, 5.5903, 8.3469, 17.133, 10.336), '[s/rad]')
    fp3: tuple[float, ...] = parameter(
        (0.039533, 0.025882, -0.04607, 0.036194, 0.026226, -0.021047, 0.0035526), '[rad/s]')


class RepulsionSettings(Settings):
    """What keeps joints from their bounds."""

    enabled: bool = parameter(True, 'whether it acts')
    safe_range: float = parameter(0.1, 'distance from which it acts [rad]', ge=0.01, le=1.0)
    max_torque: float = _gain(5.0, 'torque at the bound [N*m]', most=50.0)


class NoiseSettings(Settings):
    """Noise of the torques."""

    add_random_noise: bool = parameter(False, 'has no effect: upstream declares it alone')
    amplitude: float = _gain(0.0, 'has no effect: upstream declares it alone', most=10.0)


class LogSettings(Settings):
    """What upstream prints; the topics and controller states show it here."""

    enabled: bool = parameter(False, 'has no effect')
    robot_state: bool = parameter(False, 'has no effect')
    control_values: bool = parameter(False, 'has no effect')
    limits: bool = parameter(False, 'has no effect')
    controller_parameters: bool = parameter(False, 'has no effect')
    computed_torques: bool = parameter(False, 'has no effect')
    dynamic_params: bool = parameter(False, 'has no effect')
    timing: bool = parameter(False, 'has no effect')


class StiffnessTopicSettings(Settings):
    """A topic that sets six stiffnesses."""

    enabled: bool = parameter(False, 'whether its messages are taken')
    topic: str = parameter('target_stiffness', 'its name, from when it is loaded on', min_length=1)


class MaxStiffnessSettings(Settings):
    """The largest stiffness that takes effect."""

    translational: float = _gain(900.0, '[N/m]')
    rotational: float = _gain(60.0, '[N*m/rad]', most=100.0)


class _ComplianceParameters(ControllerParameters):
    """What both controllers have."""

    joints: tuple[str, ...] = fixed((), 'controlled joints')
    end_effector_frame: str = fixed('', 'link that is controlled')
    base_frame: str = fixed(
        '', "frame of targets; '' and a frame that the robot lacks are its root link")
    use_operational_space: bool = parameter(
        False, "whether forces are scaled by the tip's inertia")
    operational_space_regularization: float = parameter(
        0.01, "of the inverse of the tip's inertia", ge=0.001, le=1.0)
    task: TaskSettings = parameter(TaskSettings(), 'spring and damper of the tip')
    nullspace: NullspaceSettings = parameter(NullspaceSettings(), 'what holds the posture')
    use_friction: bool = parameter(False, 'compensate the friction')
    use_coriolis_compensation: bool = parameter(
        False, 'compensate Coriolis and centrifugal forces')
    use_gravity_compensation: bool = parameter(
        False, 'compensate gravity, which the hardware of some robots does by itself')
    use_local_jacobian: bool = parameter(
        False, "whether gains and wrenches are in the tip's axes, not in the base frame's")
    filter: SmoothingSettings = parameter(SmoothingSettings(), 'smoothing')
    limit_error: bool = parameter(True, 'clip the error to task.error_clip')
    limit_torques: bool = parameter(True, 'limit the change of the torques to max_delta_tau')
    max_delta_tau: float = parameter(0.5, 'in each update [N*m]', ge=0.0)
    stop_commands: bool = parameter(False, 'command nothing more; the last torques stay')
    joint_limit_repulsion: RepulsionSettings = parameter(
        RepulsionSettings(), 'what keeps joints from their bounds')
    friction: FrictionSettings = parameter(FrictionSettings(), 'the friction that is compensated')
    noise: NoiseSettings = parameter(NoiseSettings(), 'has no effect')
    log: LogSettings = parameter(LogSettings(), 'has no effect')
    enable_introspection: bool = parameter(False, 'has no effect')
    variable_stiffness: StiffnessTopicSettings = parameter(
        StiffnessTopicSettings(), 'a topic that sets the stiffness of the tip')
    command_timeout: float = parameter(
        0.0, 'hold where no target came for so long, 0 is never; not of upstream [s]', ge=0.0)

    @model_validator(mode='before')
    @classmethod
    def _weights_of_all_joints(cls, data: Any) -> Any:
        nullspace = (data.get('nullspace') or {}) if isinstance(data, Mapping) else None
        if not isinstance(nullspace, Mapping):
            return data
        weights = entry_per_name(data.get('joints', ()), nullspace.get('weights', {}))
        return {**data, 'nullspace': {**nullspace, 'weights': weights}}

    @model_validator(mode='after')
    def _as_many_as_joints(self) -> Self:
        for name in ('fp1', 'fp2', 'fp3') if self.use_friction else ():
            count = len(getattr(self.friction, name))
            if count < len(self.joints):
                raise ValueError(f'friction.{name} has {count} values and joints '
                                 f'{len(self.joints)}')
        return self

    @property
    def most_stiffness(self) -> MaxStiffnessSettings:
        """The largest stiffness of the tip that takes effect."""
        raise NotImplementedError

    @property
    def posture_is_critically_damped(self) -> bool:
        """Whether the damping of the posture follows from its stiffness."""
        return self.nullspace.damping < 0.0


class CartesianControllerParameters(_ComplianceParameters):
    """Parameters of ``crisp_controllers/CartesianController``."""

    variable_max_stiffness: MaxStiffnessSettings = parameter(
        MaxStiffnessSettings(), 'the largest stiffness that takes effect')

    @property
    def most_stiffness(self) -> MaxStiffnessSettings:
        """The largest stiffness of the tip that takes effect."""
        return self.variable_max_stiffness

    @property
    def posture_is_critically_damped(self) -> bool:
        """Whether the damping of the posture follows from its stiffness: upstream also at 0."""
        return self.nullspace.damping <= 0.0


class YieldingSettings(Settings):
    """Mass, spring and damper between the target and the pose that the tip follows."""

    mass_x: float = _gain(1.0, '[kg]', 0.001, 100.0)
    mass_y: float = _gain(1.0, '[kg]', 0.001, 100.0)
    mass_z: float = _gain(1.0, '[kg]', 0.001, 100.0)
    mass_rx: float = _gain(0.1, '[kg*m^2]', 0.001, 100.0)
    mass_ry: float = _gain(0.1, '[kg*m^2]', 0.001, 100.0)
    mass_rz: float = _gain(0.1, '[kg*m^2]', 0.001, 100.0)
    stiffness_x: float = _gain(200.0, '[N/m]')
    stiffness_y: float = _gain(200.0, '[N/m]')
    stiffness_z: float = _gain(200.0, '[N/m]')
    stiffness_rx: float = _gain(10.0, '[N*m/rad]')
    stiffness_ry: float = _gain(10.0, '[N*m/rad]')
    stiffness_rz: float = _gain(10.0, '[N*m/rad]')
    damping_x: float = _gain(50.0, '[N*s/m]')
    damping_y: float = _gain(50.0, '[N*s/m]')
    damping_z: float = _gain(50.0, '[N*s/m]')
    damping_rx: float = _gain(5.0, '[N*m*s/rad]')
    damping_ry: float = _gain(5.0, '[N*m*s/rad]')
    damping_rz: float = _gain(5.0, '[N*m*s/rad]')


class WrenchTopicSettings(Settings):
    """Where the measured wrench comes from."""

    topic: str = parameter(
        'ft_sensor_wrench', 'name of the topic, from when it is loaded on', min_length=1)
    frame: str = fixed('', "link of the sensor; '' is end_effector_frame")


class CartesianAdmittanceControllerParameters(_ComplianceParameters):
    """Parameters of ``crisp_controllers/CartesianAdmittanceController``."""

    variable_max_impedance_stiffness: MaxStiffnessSettings = parameter(
        MaxStiffnessSettings(), 'the largest stiffness that takes effect')
    admittance: YieldingSettings = parameter(YieldingSettings(), 'how the target yields')
    ft_sensor: WrenchTopicSettings = parameter(WrenchTopicSettings(), 'the sensor')
    variable_max_admittance_stiffness: MaxStiffnessSettings = parameter(
        MaxStiffnessSettings(), 'the largest stiffness of the admittance that takes effect')
    variable_admittance_stiffness: StiffnessTopicSettings = parameter(
        StiffnessTopicSettings(topic='target_admittance_stiffness'),
        'a topic that sets the stiffness of the admittance')

    @property
    def most_stiffness(self) -> MaxStiffnessSettings:
        """The largest stiffness of the tip that takes effect."""
        return self.variable_max_impedance_stiffness


class TipBroadcasterParameters(ControllerParameters):
    """What the broadcasters of the tip have; upstream's messages have these frames."""

    joints: tuple[str, ...] = configured((), 'joints before the link')
    end_effector_frame: str = configured('', 'the link')
    base_frame: str = configured('', 'frame of poses')
    publish_frequency: float = fixed(250.0, 'messages a second, 0 is each update [Hz]', ge=0.0)


class CrispPoseBroadcasterParameters(TipBroadcasterParameters):
    """Parameters of ``crisp_controllers/PoseBroadcaster``."""


class CrispTwistBroadcasterParameters(TipBroadcasterParameters):
    """Parameters of ``crisp_controllers/TwistBroadcaster``."""


class SolverSettings(Settings):
    """From a net force to the joints."""

    error_scale: float = parameter(1.0, 'factor of the net force')
    iterations: int = parameter(1, 'steps of 0.02 s of the internal model in an update', ge=1,
                                le=1000)
    publish_state_feedback: bool = parameter(False, 'publish current_pose and current_twist')


class AxisGains(Settings):
    """Gains of an axis of the base link."""

    p: float = parameter(0.0, 'proportional gain')
    d: float = parameter(0.0, 'derivative gain')


class PdSettings(Settings):
    """Gains of the axes of the base link."""

    trans_x: AxisGains = parameter(AxisGains(), 'along x')
    trans_y: AxisGains = parameter(AxisGains(), 'along y')
    trans_z: AxisGains = parameter(AxisGains(), 'along z')
    rot_x: AxisGains = parameter(AxisGains(), 'about x')
    rot_y: AxisGains = parameter(AxisGains(), 'about y')
    rot_z: AxisGains = parameter(AxisGains(), 'about z')


class StiffnessSettings(Settings):
    """Springs along the axes of compliance_ref_link."""

    trans_x: float = parameter(500.0, '[N/m]')
    trans_y: float = parameter(500.0, '[N/m]')
    trans_z: float = parameter(500.0, '[N/m]')
    rot_x: float = parameter(50.0, '[N*m/rad]')
    rot_y: float = parameter(50.0, '[N*m/rad]')
    rot_z: float = parameter(50.0, '[N*m/rad]')


class NetForceParameters(ControllerParameters):
    """Common parameters; what is needed and empty is reported when it is configured."""

    # Two names have slashes.
    model_config = ConfigDict(populate_by_name=True)

    robot_base_link: str = configured('', 'link before the joints')
    end_effector_link: str = configured('', 'link that is controlled')
    joints: tuple[str, ...] = configured((), 'controlled joints')
    command_interfaces: tuple[Literal['position', 'velocity'], ...] = configured(
        (), 'interfaces to claim')
    ik_solver: Literal[
        'forward_dynamics', 'jacobian_transpose', 'damped_least_squares',
        'selectively_damped_least_squares'] = configured(
            'forward_dynamics', 'how a net force moves the joints')
    solver: SolverSettings = parameter(SolverSettings(), 'from a net force to the joints')
    link_mass: float = parameter(0.1, 'mass of the links of the internal model [kg]', gt=0.0,
                                 alias='solver/forward_dynamics/link_mass')
    alpha: float = parameter(1.0, 'damping of the least squares', ge=0.0,
                             alias='solver/damped_least_squares/alpha')
    pd_gains: PdSettings = parameter(PdSettings(), 'gains of the net force')
    robot_description: str = fixed('', 'has no effect: the URDF file is read')

    @property
    def needed(self) -> dict[str, object]:
        """What has to be given -> its value."""
        return {name: getattr(self, name) for name in (
            'robot_base_link', 'end_effector_link', 'joints', 'command_interfaces')}

    @property
    def links(self) -> dict[str, str]:
        """Parameters that name links of the chain -> the link."""
        return {}


class CartesianMotionControllerParameters(NetForceParameters):
    """Parameters of ``cartesian_motion_controller/CartesianMotionController``."""


class CartesianForceControllerParameters(NetForceParameters):
    """Parameters of ``cartesian_force_controller/CartesianForceController``."""

    ft_sensor_ref_link: str = configured('', 'link of the sensor')
    hand_frame_control: bool = parameter(
        True, "whether target_wrench is in the axes of end_effector_link, not in the base link's")

    @property
    def links(self) -> dict[str, str]:
        """Parameters that name links of the chain -> the link."""
        return {'ft_sensor_ref_link': self.ft_sensor_ref_link}


class CartesianComplianceControllerParameters(CartesianForceControllerParameters):
    """Parameters of ``cartesian_compliance_controller/CartesianComplianceController``."""

    compliance_ref_link: str = configured('', 'link in whose axes it yields')
    stiffness: StiffnessSettings = parameter(StiffnessSettings(), 'springs to the target')

    @property
    def links(self) -> dict[str, str]:
        """Parameters that name links of the chain -> the link."""
        return {**super().links, 'compliance_ref_link': self.compliance_ref_link}
