# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Random messages to every service, topic and action that the graph of a running stack shows.

``--messages N`` are sent in all, ``--seed`` draws others. Each request has to be answered, the
arm stands still meanwhile, a refused file leaves the planning scene byte for byte as it was (a
scene message is applied part by part), the first scene can be put back after every edit, and
afterwards the stack plans and moves as before.

Left out is what is no garbage: a time on ``/clock``, the wish that the simulation ends or unloads
its world, and commands to servo that a robot can follow.
"""

from __future__ import annotations

from collections import Counter
import copy
import math
import os
from tempfile import TemporaryDirectory
import time
from typing import Any

from action_msgs.msg import GoalInfo
from action_msgs.srv import CancelGoal
from control_msgs.msg import JointJog
from geometry_msgs.msg import PoseStamped, TwistStamped
from moveit_msgs.msg import LinkPadding, LinkScale, PlanningScene
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene
from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import (
    GetParameters,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.duration import Duration
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import SetSimulationState
from tf2_msgs.msg import TFMessage

from armsim_ros.clients.client_node import ClientNode
from benchmarks.endurance.random_messages import Endpoint, endpoints, RandomMessages
from benchmarks.endurance.soak_client import SoakClient
from benchmarks.options import Options
from benchmarks.stack import arm_of, joint_states_of, running_stack

#: Every request is answered within this time [s], also on a busy machine.
ANSWERED = 30.0
#: How far a joint may be from where it stood [rad]: an arm that holds its place trembles less.
STILL = 2e-3
#: What planning and inverse kinematics may take at most [s], and a step along a path [m].
LONGEST, SHORTEST_STEP = 0.1, 1e-3
#: Topics that change the planning scene.
SCENE_TOPICS = (
    'attached_collision_object', 'collision_object', 'planning_scene', 'planning_scene_world',
    'tf', 'tf_static',
)
#: Packages of services that only tell something.
ASKING = ('rcl_interfaces', 'type_description_interfaces')
LEFT_OUT = ('/clock', '/unload_world')
#: Ends of names of what stops an arm until it is released, in the namespace of each robot.
STOPS = ('/protective_stop', '/emergency_stop', '/power_off')
#: Services that change it.
EDITS = ('apply_planning_scene', 'load_geometry_from_file')
PLAYING = SimulationState(state=SimulationState.STATE_PLAYING)
QUITTING = SimulationState.STATE_QUITTING
_PARAMETERS = (SetParameters, SetParametersAtomically)
#: Kinds of messages in which names that exist would say something that is no garbage.
NAMELESS = (JointState, TFMessage)


class Fuzz:
    """
    Sends messages to all endpoints that it finds, and notes what should not be.

    :param client: a node beside the stack.
    :param joint_states: topic of the arm's joint states.
    :param names: texts that mean something to the stack.
    :param seed: of the messages.
    :param namespace: of move_group.
    :param left_out: names of nodes that are none of the stack's.
    """

    def __init__(
        self, client: ClientNode, joint_states: str, names: tuple[str, ...], *, seed: int = 0,
        namespace: str = '', left_out: tuple[str, ...] = ()
    ) -> None:
        self._client, self._namespace = client, namespace
        self._left_out = (client.node.get_name(), *left_out)
        self._names, self._seed = names, seed
        #: What went wrong, and how often.
        self.faults: Counter[str] = Counter()
        #: Messages sent by sort.
        self.sent: Counter[str] = Counter()
        self._kinds: dict[str, Any] = {}
        self._publishers: dict[str, Any] = {}
        self._watch = client.collect(joint_states, JointState)
        first = self._watch.wait(1)[0]
        self._stood = dict(zip(first.name, first.position, strict=True))
        self._scene = self._current_scene()

    def run(self, count: int) -> None:
        """Send so many messages, more of them where more than parameters are asked for."""
        found = self._found()
        weights = [1 if one.kind.__module__.startswith('rcl_interfaces') else 4 for one in found]
        numbers: list[int] = []
        share = 0.0
        for weight in weights:
            share += count * weight / sum(weights)
            numbers.append(max(1, round(share) - sum(numbers)))
        self._publishers = {  # whoever listens matches them
            one.name: self._client.node.create_publisher(one.kind, one.name, latched(number))
            for one, number in zip(found, numbers, strict=True) if not one.is_service
        }
        self._kinds = {one.name: one.kind for one in found if one.is_service}
        self._client.connect(self._kinds)
        for endpoint, number in zip(found, numbers, strict=True):
            self._hammer(endpoint, number)
        self.sent['endpoints'] = len(found)

    def _found(self) -> list[Endpoint]:
        """Return what the graph shows once it grows no more."""
        found: list[Endpoint] = []
        while len(found) < len(now := endpoints(self._client.node, self._left_out)):
            found = now
            self._client.settle()
        return [one for one in found if one.name not in LEFT_OUT and not one.name.endswith(STOPS)]

    def _hammer(self, endpoint: Endpoint, count: int) -> None:
        """Send so many messages to an endpoint; all has to be afterwards as it was."""
        settings = endpoint.kind in _PARAMETERS
        names = self._names
        if settings:
            before = self._parameters(endpoint.node)
            names = (*names, *before)
        elif endpoint.kind in NAMELESS:
            names = ()
        messages = RandomMessages(names, self._seed + sum(self.sent.values()))
        for _ in range(count):
            kind = endpoint.kind.Request if endpoint.is_service else endpoint.kind
            self._send(endpoint, tame(messages.of_type(kind)))
        if not endpoint.is_service:
            self._arrived(endpoint, count)
        elif endpoint.node == '/simulation':
            self._play()
        if settings:
            self._set_parameters(endpoint.node, before)
        elif endpoint.kind.__module__.startswith(ASKING):
            return
        self._look(endpoint)

    def _play(self) -> None:
        """Let the physics run, whatever has stopped them."""
        play = SetSimulationState.Request(state=PLAYING)
        self._client.call('/set_simulation_state', SetSimulationState, play)
        self._watch.clear()

    def _look(self, endpoint: Endpoint) -> None:
        """Look whether the arm stands where it stood and the scene is what it was."""
        farthest = max(
            (abs(position - self._stood[name]) for message in self._watch.wait(1)
             if set(message.name) == set(self._stood)
             for name, position in zip(message.name, message.position, strict=True)),
            default=0.0)
        self._watch.clear()
        if not farthest <= STILL:
            self.faults[f'{endpoint.name}: the arm moved by {farthest:.4f}'] += 1
        changes = self._edits(endpoint)
        if endpoint.name.startswith('/tf'):
            self._scene = self._current_scene()  # knows the frames for good
        if changes and not self._apply(self._scene):
            self.faults[f'{endpoint.name}: the scene is refused: {self._scene!r:.2000}'] += 1
        now = self._current_scene()
        if repr(now) != repr(self._scene):
            what = 'the first scene does not come back' if changes else 'the scene has changed'
            self.faults[f'{endpoint.name}: {what}: {_difference(self._scene, now)}'] += 1
            self._scene = now

    def _send(self, endpoint: Endpoint, message: Any) -> None:
        self.sent['requests' if endpoint.is_service else 'messages'] += 1
        try:
            if not endpoint.is_service:
                self._publishers[endpoint.name].publish(message)
            elif endpoint.name.endswith('/_action/send_goal'):
                self._goal(endpoint, message)
            elif self._edits(endpoint):
                self._edit(endpoint, message)
            else:
                self._ask(endpoint.name, message)
        except AssertionError as error:
            self.faults[f'{error}, asked {message!r:.400}'] += 1

    def _ask(self, name: str, message: Any) -> Any:
        return self._client.call(name, self._kinds[name], message, ANSWERED)

    def _edit(self, endpoint: Endpoint, message: Any) -> None:
        """Ask for an edit; a file that is refused leaves the scene as it was."""
        before = self._current_scene()
        if self._ask(endpoint.name, message).success:
            return
        self.sent['refused edits'] += 1
        if endpoint.name.endswith('/apply_planning_scene'):
            return
        now = self._current_scene()
        if repr(now) != repr(before):
            self.faults[f'{endpoint.name}: refused, and yet {_difference(before, now)}, asked '
                        f'{message!r:.400}'] += 1

    def _goal(self, endpoint: Endpoint, message: Any) -> None:
        """Send a goal; where it is accepted, cancel it and wait for the result."""
        if self._ask(endpoint.name, message).accepted:
            self.sent['goals accepted'] += 1
            action = endpoint.name.removesuffix('/send_goal')
            cancel = CancelGoal.Request(goal_info=GoalInfo(goal_id=message.goal_id))
            self._ask(f'{action}/cancel_goal', cancel)
            result = self._kinds[f'{action}/get_result'].Request(goal_id=message.goal_id)
            self._ask(f'{action}/get_result', result)

    def _arrived(self, endpoint: Endpoint, count: int) -> None:
        """Wait until a node has taken the messages it was sent, and send it no more."""
        publisher = self._publishers.pop(endpoint.name)
        publisher.wait_for_all_acked(Duration(seconds=ANSWERED))
        for _ in range(count):  # between two answers an executor takes a message of each topic
            self._client.call(f'{endpoint.node}/list_parameters', ListParameters)
        self._client.in_executor(lambda: self._client.node.destroy_publisher(publisher))

    def _edits(self, endpoint: Endpoint) -> bool:
        """Return whether an endpoint is there to change the scene."""
        last = endpoint.name.rpartition('/')[2]
        return last in (EDITS if endpoint.is_service else SCENE_TOPICS)

    def _current_scene(self) -> PlanningScene:
        """Return the whole scene without what time changes."""
        name = f'{self._namespace}/get_planning_scene'
        scene: PlanningScene = self._client.call(name, GetPlanningScene).scene
        self._joints = scene.robot_state.joint_state
        scene.robot_state.joint_state = JointState()
        # A link without shapes, too, has a padding and a scale once it was given them.
        self._padded = {item.link_name for item in scene.link_padding}
        self._scaled = {item.link_name for item in scene.link_scale}
        scene.link_padding = [item for item in scene.link_padding if item.padding != 0.0]
        scene.link_scale = [item for item in scene.link_scale if item.scale != 1.0]
        return scene

    def _apply(self, scene: PlanningScene) -> bool:
        self._current_scene()  # for the joints, and the links that have a padding now
        request = ApplyPlanningScene.Request(scene=copy.deepcopy(scene))
        # Without joints a scene keeps what is attached.
        request.scene.robot_state.joint_state = self._joints
        none = [LinkPadding(link_name=name, padding=0.0) for name in self._padded]
        own_size = [LinkScale(link_name=name, scale=1.0) for name in self._scaled]
        request.scene.link_padding = [*none, *scene.link_padding]
        request.scene.link_scale = [*own_size, *scene.link_scale]
        name = f'{self._namespace}/apply_planning_scene'
        return bool(self._client.call(name, ApplyPlanningScene, request).success)

    def _parameters(self, node: str) -> dict[str, Any]:
        """Return the values of all parameters of a node."""
        names = self._client.call(f'{node}/list_parameters', ListParameters).result.names
        values = self._client.call(
            f'{node}/get_parameters', GetParameters, GetParameters.Request(names=names)).values
        return dict(zip(names, values, strict=True))

    def _set_parameters(self, node: str, values: dict[str, Any]) -> None:
        """Set what has changed to what it was."""
        changed = [
            Parameter(name=name, value=values[name])
            for name, value in self._parameters(node).items()
            if name in values and repr(values[name]) != repr(value)]
        answer = self._client.call(
            f'{node}/set_parameters', SetParameters, SetParameters.Request(parameters=changed))
        for parameter, result in zip(changed, answer.results, strict=True):
            if not result.successful:
                self.faults[f'{node}: {parameter.name} does not come back: {result.reason}'] += 1


def latched(number: int) -> QoSProfile:
    """
    Return a profile that keeps so many messages for who listens.

    Fast DDS asks the readers for acknowledgements with the message that fills the history, and
    else up to three seconds later.
    """
    return QoSProfile(depth=number, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


def tame(part: Any) -> Any:
    """Return a message that takes no more than a moment and asks for no motion of servo."""
    for field in part.get_fields_and_field_types():
        value = getattr(part, field)
        if field == 'allowed_planning_time' and not value <= LONGEST:
            part.allowed_planning_time = LONGEST
        elif field == 'timeout':
            value.sec, value.nanosec = 0, int(1e9 * LONGEST)
        elif field == 'max_step' and 0.0 < value < SHORTEST_STEP:
            part.max_step = SHORTEST_STEP
        elif field == 'plan_only':
            part.plan_only = True
        elif field == 'force_kill':
            part.force_kill = False
        elif hasattr(value, 'get_fields_and_field_types'):
            tame(value)
        elif isinstance(value, list) and value and hasattr(value[0], 'get_fields_and_field_types'):
            for item in value:
                tame(item)
    if isinstance(part, SetSimulationState.Request) and part.state.state == QUITTING:
        part.state.state = 200
    elif isinstance(part, TwistStamped):
        part.twist.linear.x = math.nan
    elif isinstance(part, PoseStamped):
        part.pose.position.x = math.nan
    elif isinstance(part, JointJog):
        part.velocities = part.displacements = [math.nan]
    return part


def _difference(before: Any, after: Any) -> str:
    """Return where two messages of a type differ, with the first values."""
    for field in before.get_fields_and_field_types():
        old, new = getattr(before, field), getattr(after, field)
        if repr(old) == repr(new):
            continue
        if hasattr(old, 'get_fields_and_field_types'):
            return f'{field}.{_difference(old, new)}'
        if isinstance(old, list) and len(old) == len(new):
            index, old, new = next((i, a, b) for i, (a, b) in enumerate(zip(old, new, strict=True))
                                   if repr(a) != repr(b))
            field = f'{field}[{index}]'
        return f'{field} is {new!r:.200} after {old!r:.200}'
    return 'nothing'


def main(options: Options) -> None:
    """Print what was sent and what went wrong; then plan and move."""
    with TemporaryDirectory() as home:
        os.environ['ROS_HOME'] = home  # of the stack, for the files that it is asked to write
        with (
            # The simulation tells of its world when it likes, which no request has asked for.
            running_stack(f'robot:={options.robot}', 'scene_from_world:=false') as stack,
            ClientNode(stack.domain, 'fuzz') as client,
        ):
            robot = SoakClient(client, options.robot)
            _, joints = arm_of(options.robot)
            names = (robot.group, robot.tip, *joints[:3], 'world', 'ompl', 'RRTConnect', 'LIN')
            fuzz = Fuzz(client, joint_states_of(options.robot), names, seed=options.seed,
                        left_out=(stack.client.node.get_name(),))
            programs = stack.processes()
            began = time.monotonic()
            fuzz.run(options.messages)
            print(f'{time.monotonic() - began:.0f} s: '
                  + ', '.join(f'{count} {what}' for what, count in fuzz.sent.items()))
            for what, count in fuzz.faults.items():
                print(f'{count} x {what}')
            robot.moves()
            print('afterwards:', *robot.done)
            print('the same processes' if stack.processes() == programs else 'A PROCESS ENDED')
            for text in ('please report', 'Traceback', 'internal error'):
                print(f"{stack.program.text.count(text)} times '{text}' in the log")
            if 'please report' in stack.program.text:
                print(stack.program.text)
