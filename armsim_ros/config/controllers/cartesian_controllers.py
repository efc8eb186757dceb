# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of FZI's cartesian_controllers, as they declare them."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict

from armsim_ros.config.base import ControllerParameters, parameter, Settings


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

    robot_base_link: str = parameter('', 'link before the joints', read_only=True)
    end_effector_link: str = parameter('', 'link that is controlled', read_only=True)
    joints: tuple[str, ...] = parameter((), 'controlled joints', read_only=True)
    command_interfaces: tuple[Literal['position', 'velocity'], ...] = parameter(
        (), 'interfaces to claim', read_only=True)
    ik_solver: Literal[
        'forward_dynamics', 'jacobian_transpose', 'damped_least_squares',
        'selectively_damped_least_squares'] = parameter(
            'forward_dynamics', 'how a net force moves the joints', read_only=True)
    solver: SolverSettings = parameter(SolverSettings(), 'from a net force to the joints')
    link_mass: float = parameter(0.1, 'mass of the links of the internal model [kg]', gt=0.0,
                                 alias='solver/forward_dynamics/link_mass')
    alpha: float = parameter(1.0, 'damping of the least squares', ge=0.0,
                             alias='solver/damped_least_squares/alpha')
    pd_gains: PdSettings = parameter(PdSettings(), 'gains of the net force')
    robot_description: str = parameter('', 'has no effect: the URDF file is read', read_only=True)

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

    ft_sensor_ref_link: str = parameter('', 'link of the sensor', read_only=True)
    hand_frame_control: bool = parameter(
        True, "whether target_wrench is in the axes of end_effector_link, not in the base link's")

    @property
    def links(self) -> dict[str, str]:
        """Parameters that name links of the chain -> the link."""
        return {'ft_sensor_ref_link': self.ft_sensor_ref_link}


class CartesianComplianceControllerParameters(CartesianForceControllerParameters):
    """Parameters of ``cartesian_compliance_controller/CartesianComplianceController``."""

    compliance_ref_link: str = parameter('', 'link in whose axes it yields', read_only=True)
    stiffness: StiffnessSettings = parameter(StiffnessSettings(), 'springs to the target')

    @property
    def links(self) -> dict[str, str]:
        """Parameters that name links of the chain -> the link."""
        return {**super().links, 'compliance_ref_link': self.compliance_ref_link}
