# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The buffer of a node."""

from __future__ import annotations

from collections.abc import Callable
import threading
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.clock import Clock, JumpThreshold, TimeJump
from rclpy.duration import Duration
import rclpy.logging
from rclpy.node import Node
from rclpy.task import Future
from tf2_msgs.srv import FrameGraph
from tf2_py import BufferCore, TransformException

from tf2_ros.buffer_interface import AT_ONCE, BufferInterface


class Buffer(BufferCore, BufferInterface):
    """
    The frames that a TransformListener has heard of.

    :param cache_time: how long samples are kept (default: 10 s).
    :param node: gets the service tf2_frames, and its clock empties the buffer when it jumps back.
    """

    def __init__(self, cache_time: Duration | None = None, node: Node | None = None) -> None:
        BufferCore.__init__(self, cache_time)
        BufferInterface.__init__(self)
        self._changed = threading.Condition()
        self._awaited: list[tuple[Future, Callable[[], TransformStamped]]] = []
        if node is not None:
            self.srv = node.create_service(FrameGraph, 'tf2_frames', self._send_frames)
        self.clock = Clock() if node is None else node.get_clock()
        self.jump_handle = self.clock.create_jump_callback(
            JumpThreshold(min_forward=None, min_backward=Duration(seconds=-1),
                          on_clock_change=True),
            post_callback=self.time_jump_callback)

    def time_jump_callback(self, time_jump: TimeJump) -> None:
        """Empty the buffer: what comes next has older stamps."""
        rclpy.logging.get_logger('tf2_buffer').warning(
            'Detected jump back in time. Clearing tf buffer.')
        self.clear()

    def set_transform(self, transform: TransformStamped, authority: str) -> None:
        """Add a sample of a moving frame; parameters as in BufferCore."""
        super().set_transform(transform, authority)
        self._announce()

    def set_transform_static(self, transform: TransformStamped, authority: str) -> None:
        """Set the pose of a static frame; parameters as in BufferCore."""
        super().set_transform_static(transform, authority)
        self._announce()

    def lookup_transform(self, target_frame: str, source_frame: str, time: Any,
                         timeout: Duration = AT_ONCE) -> TransformStamped:
        """
        Return the pose of the source frame in the target frame.

        :param time: of rclpy or builtin_interfaces; 0: the latest that all frames have.
        :param timeout: how long to wait for it. The frames have to arrive meanwhile: in another
            thread, or in another callback group of a multi-threaded executor.
        :raises tf2_py.TransformException: as BufferCore.lookup_transform_core.
        """
        if timeout.nanoseconds:
            self.can_transform(target_frame, source_frame, time, timeout)
        return self.lookup_transform_core(target_frame, source_frame, time)

    def lookup_transform_full(self, target_frame: str, target_time: Any, source_frame: str,
                              source_time: Any, fixed_frame: str,
                              timeout: Duration = AT_ONCE) -> TransformStamped:
        """
        Return the pose of the source frame at a time in the target frame at another time.

        :param fixed_frame: the frame that is fixed between the two times.

        Other parameters and exceptions as lookup_transform.
        """
        arguments = (target_frame, target_time, source_frame, source_time, fixed_frame)
        if timeout.nanoseconds:
            self.can_transform_full(*arguments, timeout)
        return self.lookup_transform_full_core(*arguments)

    async def lookup_transform_async(self, target_frame: str, source_frame: str,
                                     time: Any) -> TransformStamped:
        """Wait without a limit, then do as lookup_transform."""
        found: TransformStamped = await self.wait_for_transform_async(
            target_frame, source_frame, time)
        return found

    async def lookup_transform_full_async(
            self, target_frame: str, target_time: Any, source_frame: str, source_time: Any,
            fixed_frame: str) -> TransformStamped:
        """Wait without a limit, then do as lookup_transform_full."""
        found: TransformStamped = await self.wait_for_transform_full_async(
            target_frame, target_time, source_frame, source_time, fixed_frame)
        return found

    def can_transform(self, target_frame: str, source_frame: str, time: Any,
                      timeout: Duration = AT_ONCE,
                      return_debug_tuple: bool = False) -> bool | tuple[bool, str]:
        """
        Return whether lookup_transform is possible, now or within the timeout.

        :param return_debug_tuple: return the reason as well.
        """
        result = self._wait(timeout, lambda: self.can_transform_core(
            target_frame, source_frame, time))
        return result if return_debug_tuple else result[0]

    def can_transform_full(self, target_frame: str, target_time: Any, source_frame: str,
                           source_time: Any, fixed_frame: str, timeout: Duration = AT_ONCE,
                           return_debug_tuple: bool = False) -> bool | tuple[bool, str]:
        """
        Return whether lookup_transform_full is possible, now or within the timeout.

        :param return_debug_tuple: return the reason as well.
        """
        result = self._wait(timeout, lambda: self.can_transform_full_core(
            target_frame, target_time, source_frame, source_time, fixed_frame))
        return result if return_debug_tuple else result[0]

    def wait_for_transform_async(self, target_frame: str, source_frame: str, time: Any) -> Future:
        """Return a future that gets the transform as soon as it is available."""
        return self._future(lambda: self.lookup_transform_core(target_frame, source_frame, time))

    def wait_for_transform_full_async(
            self, target_frame: str, target_time: Any, source_frame: str, source_time: Any,
            fixed_frame: str) -> Future:
        """Return a future that gets the transform as soon as it is available."""
        return self._future(lambda: self.lookup_transform_full_core(
            target_frame, target_time, source_frame, source_time, fixed_frame))

    def _future(self, look_up: Callable[[], TransformStamped]) -> Future:
        future = Future()
        with self._changed:
            if not _settle(future, look_up):
                self._awaited.append((future, look_up))
        return future

    def _announce(self) -> None:
        """Let those continue that wait for what has come."""
        with self._changed:
            self._changed.notify_all()
            if self._awaited:
                # A future's callbacks may add to the list.
                awaited, self._awaited = self._awaited, []
                self._awaited += [entry for entry in awaited if not _settle(*entry)]

    def _wait(self, timeout: Duration,
              is_possible: Callable[[], tuple[bool, str]]) -> tuple[bool, str]:
        result = is_possible()
        if not result[0] and timeout.nanoseconds > 0:
            with self._changed:
                self._changed.wait_for(lambda: is_possible()[0], timeout.nanoseconds * 1e-9)
            result = is_possible()
        return result

    def _send_frames(self, _: FrameGraph.Request,
                     response: FrameGraph.Response) -> FrameGraph.Response:
        response.frame_yaml = self.all_frames_as_yaml()
        return response


def _settle(future: Future, look_up: Callable[[], TransformStamped]) -> bool:
    """Give the future its transform if it is available; return whether it waits no longer."""
    if not (future.done() or future.cancelled()):
        try:
            future.set_result(look_up())
        except TransformException:
            return False
        except TypeError as error:
            future.set_exception(error)
    return True
