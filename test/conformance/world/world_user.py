# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A client of the simulated world that knows it by ROS interfaces alone."""

from __future__ import annotations

from pathlib import Path
import re
from typing import Any

from geometry_msgs.msg import Pose, PoseStamped, Quaternion
from rosgraph_msgs.msg import Clock
from simulation_interfaces.msg import SimulationState
import simulation_interfaces.srv
from std_srvs.srv import Empty

from armsim_ros.clients.client_node import ClientNode, Collector
from armsim_ros.clients.trajectory import trajectory_message, TrajectoryClient
from armsim_ros.testing.program import Program

READY = 'You can start planning now!'
START_TIMEOUT = 60.0
UNSUPPORTED, OK, NOT_FOUND, FAILED = 0, 1, 2, 4
STOPPED, PLAYING, PAUSED, QUITTING, NO_WORLD, LOADING = range(6)
ARM = '/sunday/arm_joint_controller'
JOINTS = tuple(f'joint_{number}' for number in range(1, 7))
HERE = 'feeding_place'
BOX = 'armsim://box?size=0.05,0.05,0.05&mass=0.1'


class WorldUser:
    """
    Calls the services of the world.

    :param program: the stack, for its log.
    :param folder: where the stack may read files.
    """

    def __init__(self, client: ClientNode, program: Program, folder: Path) -> None:
        self.client, self.program, self.folder = client, program, folder
        self.arm = TrajectoryClient(client, ARM)
        self._clock: Collector | None = None

    def call(self, service: str, **request: Any) -> Any:
        """Call a service of simulation_interfaces by its name and return the response."""
        kind = getattr(simulation_interfaces.srv, type_name(service))
        return self.client.call(f'/{service}', kind, kind.Request(**request), timeout=20.0)

    def result(self, service: str, **request: Any) -> tuple[int, str]:
        """Call a service and return code and text of its result."""
        result = self.call(service, **request).result
        return result.result, result.error_message

    def gazebo(self, name: str) -> None:
        """Call a service that users of Gazebo know."""
        self.client.call(f'/gazebo/{name}', Empty)

    def become(self, state: int) -> tuple[int, str]:
        """Ask for a state of the simulation."""
        return self.result('set_simulation_state', state=SimulationState(state=state))

    @property
    def state(self) -> int:
        """The state of the simulation."""
        return int(self.call('get_simulation_state').state.state)

    def spawn(self, name: str, xyz: Any = (0.0, 0.0, 3.0), uri: str = BOX, *,
              frame: str = '', **request: Any) -> Any:
        """Spawn something; without a place high up, where nothing is."""
        return self.call('spawn_entity', name=name, uri=uri, initial_pose=stamped(xyz, frame),
                         **request)

    def entities(self) -> list[str]:
        """Return the names of all entities."""
        return list(self.call('get_entities').entities)

    def entity(self, name: str) -> Any:
        """Return the state of an entity that is there."""
        response = self.call('get_entity_state', entity=name)
        assert response.result.result == OK, response.result.error_message
        return response.state

    def position(self, name: str) -> tuple[float, float, float]:
        """Return where an entity is [m]."""
        place = self.entity(name).pose.position
        return place.x, place.y, place.z

    def time_ns(self) -> int:
        """Return the simulated time [ns]."""
        stamp = self.entity('sunday').header.stamp
        return int(stamp.sec) * 10**9 + int(stamp.nanosec)

    def clock(self) -> Collector:
        """Return what collects /clock, emptied."""
        if self._clock is None:
            self._clock = self.client.collect('/clock', Clock, 50)
        self._clock.clear()
        return self._clock

    def move(self, seconds: float = 0.5, angle: float = 0.2) -> Any:
        """Send a goal that moves all joints, and return it accepted."""
        goal = self.arm.send(trajectory_message(JOINTS, [(seconds, [angle] * 6)]))
        assert goal.accepted()
        return goal

    def put_back(self) -> None:
        """Have the world as it was at the start, playing."""
        current = self.call('get_current_world')
        if current.result.result != OK or current.world.name != HERE:
            assert self.result('load_world', uri=HERE)[0] == OK
        code, text = self.result('reset_simulation')
        assert code == OK, text
        if self.state != PLAYING:
            assert self.become(PLAYING)[0] == OK


def type_name(service: str) -> str:
    """Return the type of a service by its name."""
    return re.sub(r'(?:^|_)(\w)', lambda match: match[1].upper(), service)


def stamped(xyz: Any, frame: str = '', quaternion: Any = (0.0, 0.0, 0.0, 1.0)) -> PoseStamped:
    """Return a pose in a frame."""
    message = PoseStamped(pose=pose(xyz, quaternion))
    message.header.frame_id = frame
    return message


def pose(xyz: Any, quaternion: Any = (0.0, 0.0, 0.0, 1.0)) -> Pose:
    """Return a pose message; the quaternion is x, y, z, w."""
    x, y, z, w = map(float, quaternion)
    message = Pose(orientation=Quaternion(x=x, y=y, z=z, w=w))
    message.position.x, message.position.y, message.position.z = map(float, xyz)
    return message
