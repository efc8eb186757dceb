# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Settings of the physics, drives, cameras and the pace (``simulation.yaml``)."""

from __future__ import annotations

import math
import re
from typing import Annotated, Literal

from pydantic import AfterValidator, field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import fixed, parameter, Settings
from armsim_ros.config.controllers.pid_controller import PidGains


class CollisionSettings(Settings):
    """When a load from outside stops the arm."""

    torque: float = fixed(
        0.0, "external torque of a joint that stops the arm after 10 ms [N*m or N]; 0 takes the "
        "vendor's, and never stops an arm without a vendor", ge=0.0)
    force: float = fixed(
        0.0, "contact force that stops the arm after 10 ms [N]; 0 takes the vendor's, and never "
        'stops an arm without a vendor', ge=0.0)


class HardwareSettings(Settings):
    """The arm behind its controllers."""

    vendor: str = fixed(
        '', "'' is the vendor of the plugin in <ros2_control>, 'none' is none; or the name of a "
        'vendor, or of a Python module that has one')
    start: Literal['RUNNING', 'IDLE', 'POWER_OFF'] = fixed(
        'RUNNING', 'mode of the drives at the start')
    program: Literal['PLAYING', 'STOPPED'] = fixed(
        'PLAYING', 'what the program does at the start by which an arm of some vendors takes '
        'commands')
    io: dict[str, str] = fixed(
        {}, 'digital output -> vacuum gripper, or joint of a gripper controller, that it '
        "switches; digital input -> 'VACUUM_GRIPPER/grasping'")
    gripper: str = fixed('', "node of the hand of a vendor that has one; '' is <ARM>_gripper")
    unlock_delay: float = fixed(
        -1.0, "time that a protective stop lasts at least [s]; below 0 the vendor's, or 0",
        allow_inf_nan=False)
    watch: Literal['auto', 'always', 'never'] = fixed(
        'auto', 'whether speed, position and loads from outside can stop the arm; auto: where '
        'collision or the vendor sets a limit')
    collision: CollisionSettings = parameter(
        CollisionSettings(), 'loads from outside that stop the arm')


Triple = tuple[float, float, float]


def finite_triple(value: Triple) -> Triple:
    """Return three numbers as they are; ValueError unless all are finite."""
    if not all(math.isfinite(number) for number in value):
        raise ValueError('all three numbers must be finite')
    return value


class CameraSettings(Settings):
    """A camera that sees colour and depth from the same place."""

    link: str = fixed(
        '', "link that carries it; '' where the URDF has its frame <name>_color_optical_frame")
    xyz: Triple = fixed((0.0, 0.0, 0.0), 'where it sits in the link [m]')
    rpy: Triple = fixed((0.0, 0.0, 0.0), 'how it is turned there: x looks forward, z is up [rad]')
    width: int = fixed(640, 'columns of a picture', ge=16, le=4096)
    height: int = fixed(480, 'lines of a picture', ge=16, le=4096)
    rate: float = fixed(10.0, 'pictures a second [Hz]', gt=0.0, le=30.0)
    focal_length: float = fixed(
        1.0, 'focal length over the height of the picture', ge=0.05, le=50.0)
    range: tuple[float, float] = fixed(
        (0.1, 10.0), 'nearest and farthest depth that is measured [m]')

    _all_finite = field_validator('xyz', 'rpy')(finite_triple)

    @field_validator('range')
    @classmethod
    def _rising(cls, value: tuple[float, float]) -> tuple[float, float]:
        if not 0.02 <= value[0] < value[1] <= 1000.0:
            raise ValueError('nearest and farthest must rise between 0.02 and 1000')
        return value


class JointFault(Settings):
    """What is wrong with a joint, so that tests can make tolerances fail."""

    lag: float = parameter(
        0.0, 'time constant with which the joint follows position commands, 0 for none [s]',
        ge=0.0, allow_inf_nan=False)
    bias: float = parameter(
        0.0, 'added to the position commands of the joint [rad or m]', allow_inf_nan=False)
    blocked: bool = parameter(False, 'the joint does not move, whatever is commanded')

    def __str__(self) -> str:
        """Return the fault in words."""
        words = [f'lag {self.lag:g} s'] if self.lag else []
        words += [f'bias {self.bias:g}'] if self.bias else []
        words += ['blocked'] if self.blocked else []
        return ', '.join(words) or 'none'


class JointFaults(Settings):
    """The faults of all joints, as parameters of a node."""

    faults: dict[str, JointFault] = parameter({}, 'joint -> what is wrong with it')


#: Slowest and fastest pace that can be asked for.
SLOWEST, FASTEST = 0.1, 100.0


def checked_factor(value: float) -> float:
    """Return a real time factor as it is; ValueError for a factor that cannot be kept."""
    if value != 0.0 and not SLOWEST <= value <= FASTEST:
        raise ValueError(
            f'the real time factor must be {SLOWEST:g} to {FASTEST:g}, or 0 for as fast as it '
            f'goes, not {value:g}')
    return value


RealTimeFactor = Annotated[float, AfterValidator(checked_factor)]


class JointServoSettings(Settings):
    """How a position or velocity command becomes a torque."""

    feedforward: bool = fixed(True, 'add the inverse dynamics of the reference to the gains')
    default_gains: PidGains = fixed(
        PidGains(p=1000.0, d=0.1, i_clamp=0.0),
        'p, i, d, i_clamp of joints for which no controller gives any')
    gains: dict[str, PidGains] = fixed({}, 'joint -> gains that win over those of its controller')
    gravity_compensation: bool | None = fixed(
        None,
        'add what holds the joints against gravity to effort commands, as the drives of some '
        "robots do; without a value where the <ros2_control> tag names a vendor's driver")
    damping_ratio: float = fixed(
        0.7,
        'the derivative gain is raised to at least this ratio of critical damping, so that an '
        'arm that was pushed comes to rest; 0 takes the gains as they are', ge=0.0, le=2.0)


class PlacementSettings(Settings):
    """Pose of the robot's root link in the world."""

    xyz: Triple = fixed((0.0, 0.0, 0.0), 'position [m]')
    rpy: Triple = fixed((0.0, 0.0, 0.0), 'roll, pitch, yaw [rad]')

    _all_finite = field_validator('xyz', 'rpy')(finite_triple)


class VacuumGripperSettings(Settings):
    """A suction cup on a link."""

    link: str = fixed(description='link that carries the cup')
    xyz: Triple = fixed((0.0, 0.0, 0.0), 'rim of the cup in the link [m]')
    axis: Triple = fixed((0.0, 0.0, 1.0), 'where the cup looks to, in the link')
    reach: float = fixed(0.03, 'surfaces so near are sucked in [m]', gt=0.0, le=0.5)
    angle: float = fixed(
        math.radians(60.0), 'so far beside the axis they may lie [rad]', gt=0.0, le=math.pi)
    force: float = fixed(20.0, 'force that the cup holds [N]', gt=0.0, le=1e5)
    moment: float = fixed(1.0, 'moment that the cup holds [N*m]', gt=0.0, le=1e5)

    _all_finite = field_validator('xyz', 'axis')(finite_triple)

    @field_validator('axis')
    @classmethod
    def _some_direction(cls, value: Triple) -> Triple:
        if not any(value):
            raise ValueError('an axis of zeros has no direction')
        return value


class PaceSettings(Settings):
    """How the loop keeps to the wall clock; deterministic runs use none of it."""

    priority: int = fixed(
        10, 'SCHED_FIFO priority asked for, 0 asks for none; without the permission the loop runs '
        'at normal priority', ge=0, le=99)
    spin: float = parameter(
        0.0, 'last part of a wait that is spent polling the clock [s]', ge=0.0, le=0.001)
    catch_up: float = parameter(
        0.1,
        'delay that is made up by ticks without a wait [s]; what is beyond is dropped, counted '
        'and reported', ge=0.0, le=10.0)


class RecorderSettings(Settings):
    """What is kept of the last seconds, to be written as MCAP on request."""

    seconds: float = fixed(
        10.0, 'how far back a recording reaches [s]; 0 records nothing', ge=0.0, le=3600.0)
    folder: str = fixed(
        '', "where recordings are written; '' is armsim_recordings in ROS_HOME, or in ~/.ros")
    file: str = fixed('', 'a recording is written to this file when the simulation ends')


class SensorSettings(Settings):
    """A sensor on a link; its states are what a broadcaster of its kind reads."""

    type: Literal['force_torque', 'imu', 'pose'] = fixed(..., 'what it measures')
    link: str = fixed(..., 'where it sits, with its axes', min_length=1)


class SimulationSettings(Settings):
    """Everything about the simulated plant that is not the robot and not the world."""

    timestep: float = fixed(0.001, 'time of a physics step [s]', ge=0.0001, le=0.01)
    integrator: Literal['implicitfast', 'implicit', 'euler'] = fixed(
        'implicitfast', "MuJoCo's integrator")
    noslip_iterations: int = fixed(
        0, "further iterations of MuJoCo's solver against the creep of what is held by friction; "
        'costs time in each step with contacts', ge=0, le=100)
    gravity: Triple = fixed((0.0, 0.0, -9.8), 'gravity [m/s^2]')
    armature: float = fixed(
        0.01,
        'least inertia of rotor and gear that each rotating joint carries [kg*m^2]; a light arm '
        'is unstable without it', ge=0.0)
    armature_linear: float = fixed(0.1, 'the same for each sliding joint [kg]', ge=0.0)
    servo: JointServoSettings = parameter(JointServoSettings(), 'servo of the joints')
    world: str = parameter('', "world file or its name; '' is a floor and nothing on it")
    resource_paths: tuple[str, ...] = fixed(
        (), 'further folders that worlds, objects and their meshes may be read from')
    placement: PlacementSettings = parameter(PlacementSettings(), 'pose of the robot')
    vacuum_grippers: dict[str, VacuumGripperSettings] = fixed({}, 'name -> suction cup')
    initial_state: str = fixed('', "named state of the SRDF to start in, 'state' or 'group/state'")
    initial_positions: dict[str, float] = fixed(
        {}, 'joint -> position at the start [rad or m]; wins over the named state')
    deterministic: bool = fixed(False, 'no wall clock: time starts at zero and only steps move it')
    paused: bool = fixed(False, 'start with the physics standing still')
    real_time_factor: RealTimeFactor = parameter(
        1.0, 'simulated time per wall time; 1 is real time, 0 as fast as it goes')
    clock_rate: float = fixed(100.0, 'rate of /clock in simulated time [Hz]', gt=0.0, le=1000.0)
    state_publisher: bool = fixed(
        True, 'whether transforms and robot_description are published; false where a '
        'robot_state_publisher does that')
    sensors: dict[str, SensorSettings] = fixed(
        {}, "sensor -> its kind and link, beside those of the URDF's <ros2_control>")
    cameras: dict[str, CameraSettings] = fixed(
        {}, 'name -> camera, whose topics begin with the name')
    fault_injection: bool = fixed(
        False,
        'for tests: joints can be made to fail by the parameters faults.<joint>.lag, .bias and '
        '.blocked of the controller manager')
    hardware: HardwareSettings = parameter(HardwareSettings(), 'drives and safety of the arm')
    recorder: RecorderSettings = parameter(RecorderSettings(), 'recording of the last seconds')
    pace: PaceSettings = parameter(PaceSettings(), 'how the loop keeps to the wall clock')

    _finite_gravity = field_validator('gravity')(finite_triple)

    @field_validator('cameras')
    @classmethod
    def _topic_names(cls, value: dict[str, CameraSettings]) -> dict[str, CameraSettings]:
        for name in value:
            if re.fullmatch('[A-Za-z][A-Za-z0-9_]*', name) is None:
                raise ValueError(f"a camera cannot be called '{name}'; allowed: a letter, then "
                                 'letters, digits and underscores')
        return value

    @field_validator('initial_positions')
    @classmethod
    def _finite_positions(cls, value: dict[str, float]) -> dict[str, float]:
        wrong = [name for name, position in value.items() if not math.isfinite(position)]
        if wrong:
            raise ValueError(f"the position of '{wrong[0]}' must be finite")
        return value

    @model_validator(mode='after')
    def _whole_nanoseconds(self) -> Self:
        nanoseconds = self.timestep * 1e9
        if abs(nanoseconds - round(nanoseconds)) > 1e-3:
            raise ValueError('timestep must be a whole number of nanoseconds')
        return self

    @property
    def timestep_ns(self) -> int:
        """Time of a physics step [ns]."""
        return round(self.timestep * 1e9)
