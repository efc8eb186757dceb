# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The camera program from start to end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
import os
from pathlib import Path
import subprocess
import sys
import threading
import time
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from tf2_msgs.msg import TFMessage

from armsim_ros.cli.arguments import ProgramArguments
from armsim_ros.cli.environment import die_with_parent
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes import qos
from armsim_ros.nodes.camera.link import PictureSource
from armsim_ros.nodes.camera.topics import CameraTopics, RenderingDiagnostics
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.nodes.shutdown import shut_down
from armsim_ros.nodes.upstream.robot_state_publisher import transform
from armsim_ros.sim.camera import Camera, Snapshot

#: Wall time between checks of services and subscribers while no picture comes [s].
_REST = 0.2
#: The lowest priority that gets a share of the processor at all, and where a session has its own.
_LOWEST, _OF_SESSION = 19, Path('/proc/self/autogroup')


class CameraProgram:
    """
    Asks the simulation for what is to be shown, draws and publishes it, all in the same thread.

    At most one picture of each camera is on its way, so that a late picture is never
    begun.

    :param stop_wanted: whether a signal came.
    """

    def __init__(self, arguments: ProgramArguments, stop_wanted: Callable[[], bool]) -> None:
        self._arguments, self._stop_wanted = arguments, stop_wanted
        self._source = PictureSource(arguments.ros_args)
        self._topics: list[CameraTopics] = []
        self._asked: set[int] = set()
        self._renderer: Any = None

    def stop(self) -> None:
        """End ``run``, which reads the signals often enough by itself."""

    def run(self) -> int:
        """
        Run until a stop is requested.

        :returns: the exit status.
        """
        rclpy.init(args=['camera', *self._arguments.ros_args],
                   signal_handler_options=SignalHandlerOptions.NO)
        use_sim_time = Parameter('use_sim_time', value=self._arguments.use_sim_time)
        self._node = PollingNode('camera', parameter_overrides=[use_sim_time])
        self._diagnostics = RenderingDiagnostics(self._node)
        self._static_publisher = self._node.create_publisher(TFMessage, '/tf_static', qos.LATCHED)
        executor = SingleThreadedExecutor()
        executor.add_node(self._node)
        try:
            self._choose_backend()
            while not self._stop_wanted():
                executor.spin_once(0.0 if self._source.connected else _REST)
                self._diagnostics.publish()
                if self._diagnostics.fault:
                    continue
                if self._source.connected:
                    self._work()
                else:
                    self._serve(*self._source.connect())
        finally:
            self._source.close()
            if self._renderer is not None:
                self._renderer.close()
            executor.shutdown(0.0)
            shut_down(self._node)
        return 0

    def _choose_backend(self) -> None:
        try:
            self._diagnostics.backend = choose_backend(os.environ, self._stop_wanted)
        except NoRenderingError as error:
            self._diagnostics.fault = str(error)
            self._node.get_logger().error(self._diagnostics.fault)
        else:
            os.environ[VARIABLE] = self._diagnostics.backend

    def _serve(self, cameras: tuple[Camera, ...], plant: bytes) -> None:
        """Have the topics of a simulation that has just been found, if any."""
        if not cameras:
            return
        # Only now: this imports mujoco, which looks once at what is to draw.
        from armsim_ros.sim.scene_renderer import SceneRenderer

        for topics in self._topics:
            topics.close()
        if self._renderer is not None:
            self._renderer.close()
        self._asked.clear()
        before = _threads()
        self._renderer = SceneRenderer(cameras)
        self._renderer.load(plant)
        # It starts as any program does; from here on it draws below all others, but in lockstep,
        # where time is paused until it has drawn.
        if not self._source.lockstep:
            _give_way({threading.get_native_id(), *(_threads() - before)})
        self._topics = [CameraTopics(self._node, camera) for camera in cameras]
        self._diagnostics.cameras = len(cameras)
        frames = [transform(*arguments) for camera in cameras for arguments in camera.transforms]
        if frames:
            self._static_publisher.publish(TFMessage(transforms=frames))
        names = ', '.join(camera.name for camera in cameras)
        self._node.get_logger().info(f'cameras: {names}; drawn by {self._diagnostics.backend}')

    def _work(self) -> None:
        """Draw what has come, or wait a little for it."""
        for number, topics in enumerate(self._topics):
            if not self._source.lockstep and number not in self._asked and topics.wanted:
                self._asked.add(number)
                self._source.confirm(number)
        message = self._source.receive(_REST)
        if isinstance(message, Snapshot):
            self._asked.discard(message.camera)
            self._show(message)
            if self._source.lockstep:
                self._topics[message.camera].wait_until_taken()
                self._source.confirm(message.camera)
        elif message is not None:
            self._renderer.load(message)
        elif not self._source.connected:
            self._diagnostics.cameras = 0

    def _show(self, snapshot: Snapshot) -> None:
        topics, picture = self._topics[snapshot.camera], None
        if topics.seen:
            begin = time.monotonic()
            picture = self._renderer.draw(snapshot)
            self._diagnostics.count(time.monotonic() - begin)
        topics.publish(snapshot.time_ns, picture)


def _threads() -> set[int]:
    """Return the system's numbers of this process's threads."""
    return set(map(int, os.listdir('/proc/self/task')))


def _give_way(threads: set[int]) -> None:
    """Give these threads, and those that they start, the lowest priority."""
    for thread in threads:
        with suppress(ProcessLookupError):
            os.setpriority(os.PRIO_PROCESS, thread, _LOWEST)
    with suppress(OSError):  # where the system does not part its time between sessions
        _OF_SESSION.write_text(str(_LOWEST), encoding='ascii')


VARIABLE = 'MUJOCO_GL'
#: The libraries without a screen -> the packages that they are in.
PACKAGES = {'egl': 'libegl1 libegl-mesa0 libgl1-mesa-dri', 'osmesa': 'libosmesa6'}
#: Draws a picture of nothing, as it is to be done later.
_TRIAL = """
import mujoco
window = mujoco.GLContext(16, 16)
window.make_current()
model = mujoco.MjSpec().compile()
mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50).free()
print('drawn', flush=True)
import os
os._exit(0)
"""
#: Time between checks whether a trial has ended [s].
_LOOK = 0.05
#: A trial on a busy machine takes no longer [s].
_LONGEST_TRIAL = 120.0


class NoRenderingError(ArmsimError):
    """Nothing on this machine can draw; the text names what to install."""


def choose_backend(
    environment: Mapping[str, str], stop_wanted: Callable[[], bool] = lambda: False
) -> str:
    """
    Return the value of MUJOCO_GL that draws here: the user's own, else EGL, else OSMesa.

    Each is tried in a process of its own: what does not work may end that.

    :param environment: of the process; may hold the user's value.
    :param stop_wanted: ends the trials; '' is returned.
    :raises NoRenderingError: none works.
    """
    given = environment.get(VARIABLE, '').lower()
    for backend in (given,) if given else tuple(PACKAGES):
        if _draws(backend, environment, stop_wanted):
            return backend
        if stop_wanted():
            return ''
    if given:
        raise NoRenderingError(
            f"no pictures: {VARIABLE} is '{given}', which cannot draw here; unset it, or set it "
            f"to one of {', '.join(PACKAGES)} and install {_packages()}")
    raise NoRenderingError(
        f'no pictures: neither EGL nor OSMesa can draw here; install {_packages()}')


def _packages() -> str:
    return f"the packages {PACKAGES['egl']}, or {PACKAGES['osmesa']}"


def _draws(backend: str, environment: Mapping[str, str], stop_wanted: Callable[[], bool]) -> bool:
    """Return whether a child could draw."""
    with subprocess.Popen(
        [sys.executable, '-c', _TRIAL], env={**environment, VARIABLE: backend},
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        preexec_fn=die_with_parent(holds_sigint=False),
    ) as child:
        waited = 0.0
        while waited < _LONGEST_TRIAL and not stop_wanted():
            try:
                output, _ = child.communicate(timeout=_LOOK)
            except subprocess.TimeoutExpired:
                waited += _LOOK
                continue
            return b'drawn' in output
        child.kill()
    return False
