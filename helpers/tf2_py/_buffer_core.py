# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The tree of frames and its look-ups, with the results and exceptions of tf2::BufferCore."""

from __future__ import annotations

import threading
from typing import Any

from geometry_msgs.msg import TransformStamped
import rclpy.logging
from rclpy.time import Time

from tf2_py._cache import seconds, StaticCache, TimeCache
from tf2_py._exceptions import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformException,
)
from tf2_py._messages import nanoseconds, transform_message
from tf2_py._problems import problem_of_name, problem_of_transform
from tf2_py._rigid import compose, inverse, Pose, product, Sample, unit

_DEFAULT_CACHE_TIME = 10_000_000_000
#: Frames between a frame and its root; more are taken for a loop.
_MAX_DEPTH = 1000
#: The shortest time that a rate is computed over [ns].
_SHORTEST_SPAN = 100_000
_NEVER = 1 << 63


class BufferCore:
    """
    A tree of frames over time; all methods may be called from several threads.

    :param cache_time: how long samples of moving frames are kept, a Duration of rclpy or of
        builtin_interfaces (default: 10 s).
    """

    def __init__(self, cache_time: Any = None) -> None:
        self._cache_time = _DEFAULT_CACHE_TIME if cache_time is None else nanoseconds(
            cache_time, 'duration')
        self._lock = threading.RLock()
        #: A frame without a cache is only known as a parent.
        self._frames: dict[str, TimeCache | StaticCache | None] = {}
        self._authorities: dict[str, str] = {}
        self._logger = rclpy.logging.get_logger('tf2')

    def clear(self) -> None:
        """Remove all samples of moving frames; their names and the static frames stay."""
        with self._lock:
            for cache in self._frames.values():
                if cache is not None:
                    cache.clear()

    def set_transform(self, transform: TransformStamped, authority: str) -> None:
        """
        Add a sample of a moving frame.

        A transform that cannot be used is reported in the log and ignored.

        :param authority: the publisher, for reports.
        """
        self._insert(transform, authority, TimeCache)

    def set_transform_static(self, transform: TransformStamped, authority: str) -> None:
        """Set the pose of a static frame; parameters as in set_transform."""
        self._insert(transform, authority, StaticCache)

    def can_transform_core(
            self, target_frame: str, source_frame: str, time: Any) -> tuple[bool, str]:
        """Return whether lookup_transform_core would succeed, and why not."""
        try:
            with self._lock:
                if target_frame != source_frame:
                    self._validate_asked(target_frame=target_frame, source_frame=source_frame)
                self._path('canTransform', target_frame, source_frame, nanoseconds(time))
        except TransformException as error:
            return False, str(error)
        return True, ''

    def can_transform_full_core(
            self, target_frame: str, target_time: Any, source_frame: str, source_time: Any,
            fixed_frame: str) -> tuple[bool, str]:
        """Return whether lookup_transform_full_core would succeed, and why not."""
        try:
            with self._lock:
                self._validate_asked(target_frame=target_frame, source_frame=source_frame,
                                     fixed_frame=fixed_frame)
                self._lookup_full('canTransform', target_frame, nanoseconds(target_time),
                                  source_frame, nanoseconds(source_time), fixed_frame)
        except TransformException as error:
            return False, str(error)
        return True, ''

    def lookup_transform_core(
            self, target_frame: str, source_frame: str, time: Any) -> TransformStamped:
        """
        Return the pose of the source frame in the target frame.

        :param time: of rclpy or builtin_interfaces; 0: the latest that all frames have.
        :raises InvalidArgumentException: a name is empty or begins with a slash.
        :raises LookupException: a frame does not exist, or the frames form a loop.
        :raises ConnectivityException: the frames belong to different trees.
        :raises ExtrapolationException: a frame between them has no data for that time.
        """
        pose, stamp = self._lookup(
            'lookupTransform', target_frame, source_frame, nanoseconds(time))
        return transform_message(stamp, target_frame, source_frame, pose)

    def lookup_transform_full_core(
            self, target_frame: str, target_time: Any, source_frame: str, source_time: Any,
            fixed_frame: str) -> TransformStamped:
        """
        Return the pose of the source frame at a time in the target frame at another time.

        :param fixed_frame: the frame that is taken to be fixed between the two times.
        :raises TransformException: as lookup_transform_core.
        """
        pose, stamp = self._lookup_full(
            'lookupTransform', target_frame, nanoseconds(target_time),
            source_frame, nanoseconds(source_time), fixed_frame)
        return transform_message(stamp, target_frame, source_frame, pose)

    def get_latest_common_time(self, target_frame: str, source_frame: str) -> Time:
        """
        Return the latest time for which the transform is available; 0 if all is static.

        :raises TransformException: as lookup_transform_core.
        """
        with self._lock:
            self._validate('get_latest_common_time', target_frame)
            self._validate('get_latest_common_time', source_frame)
            if target_frame == source_frame:
                cache = self._frames[target_frame]
                return Time(nanoseconds=0 if cache is None else cache.newest_stamp())
            return Time(nanoseconds=self._latest_common_time(target_frame, source_frame))

    def all_frames_as_string(self) -> str:
        """Return a sentence for each frame that has a parent."""
        with self._lock:
            return ''.join(
                f'Frame {name} exists with parent {parent}.\n'
                for name, parent in ((name, self._parent(name) or 'NO_PARENT')
                                     for name, cache in self._frames.items() if cache is not None))

    def all_frames_as_yaml(self) -> str:
        """Return the frames with parent, publisher, rate [Hz] and times [s] as YAML."""
        with self._lock:
            return ''.join(self._frame_as_yaml(name) for name in self._frames) if (
                self._frames) else '[]'

    def _chain(self, target_frame: str, target_time: Any, source_frame: str, source_time: Any,
               fixed_frame: str) -> list[str]:
        """
        Return the names of the frames from the source frame over the fixed frame to the target.

        Parameters and exceptions as lookup_transform_full_core.
        """
        with self._lock:
            frames = [source_frame]
            for target, source, time in ((fixed_frame, source_frame, source_time),
                                         (target_frame, fixed_frame, target_time)):
                upwards, downwards, _ = self._path('_chain', target, source, nanoseconds(time))
                up = [source, *(parent for _, parent, *_ in upwards)]
                down = [target, *(parent for _, parent, *_ in downwards)]
                # Both end at the same frame, which may be above their nearest common one.
                while len(up) > 1 and len(down) > 1 and up[-2] == down[-2]:
                    del up[-1], down[-1]
                frames += [*up[1:], *reversed(down[:-1])]
            return frames

    def _frameExists(self, frame_id: str) -> bool:
        with self._lock:
            return frame_id in self._frames

    def _getFrameStrings(self) -> list[str]:
        with self._lock:
            return list(self._frames)

    def _insert(self, message: TransformStamped, authority: str,
                kind: type[TimeCache | StaticCache]) -> None:
        parent = message.header.frame_id.removeprefix('/')
        child = message.child_frame_id.removeprefix('/')
        rotation, translation = message.transform.rotation, message.transform.translation
        numbers = (rotation.x, rotation.y, rotation.z, rotation.w,
                   translation.x, translation.y, translation.z)
        problem = problem_of_transform(parent, child, numbers)
        if problem:
            self._logger.error(f'ignoring the transform from "{parent}" to "{child}" '
                               f'of authority "{authority}": {problem}')
            return
        stamp = nanoseconds(message.header.stamp)
        sample = (stamp, parent, *unit(*numbers[:4]), *numbers[4:])
        with self._lock:
            cache = self._frames.get(child)
            if type(cache) is not kind:
                cache = TimeCache(self._cache_time) if kind is TimeCache else StaticCache()
                self._frames[child] = cache
            self._frames.setdefault(parent, None)
            if cache.insert(sample):
                self._authorities[child] = authority
                return
        self._logger.warning(f'TF_OLD_DATA: ignoring data from the past for frame {child} at time '
                             f'{seconds(stamp)} of authority {authority}')

    def _lookup_full(self, function: str, target: str, target_time: int, source: str,
                     source_time: int, fixed: str) -> tuple[Pose, int]:
        with self._lock:
            for argument, name in (('target_frame', target), ('source_frame', source),
                                   ('fixed_frame', fixed)):
                self._validate(f'{function} argument {argument}', name)
            source_in_fixed, _ = self._lookup(function, fixed, source, source_time)
            fixed_in_target, stamp = self._lookup(function, target, fixed, target_time)
            return product(fixed_in_target, source_in_fixed), stamp

    def _lookup(self, function: str, target: str, source: str, time: int) -> tuple[Pose, int]:
        """Return the pose of source in target, and its time [ns]."""
        with self._lock:
            upwards, downwards, time = self._path(function, target, source, time)
        if not downwards:
            return compose(upwards), time
        target_in_top = inverse(compose(downwards))
        return product(target_in_top, compose(upwards)) if upwards else target_in_top, time

    def _path(self, function: str, target: str, source: str,
              time: int) -> tuple[list[Sample], list[Sample], int]:
        """Return the samples from source and from target up to a common frame, and their time."""
        if target == source:
            cache = self._frames.get(target)
            return [], [], time or (0 if cache is None else cache.newest_stamp())
        if target not in self._frames or source not in self._frames:
            self._validate(f'{function} argument target_frame', target)
            self._validate(f'{function} argument source_frame', source)
        if time == 0:
            time = self._latest_common_time(target, source)
        return *self._chains(target, source, time), time

    def _chains(self, target: str, source: str, time: int) -> tuple[list[Sample], list[Sample]]:
        frames = self._frames
        upwards: list[Sample] = []
        obstacle: ExtrapolationException | None = None
        top = source
        cache = frames[top]
        while cache is not None:
            if top == target:
                return upwards, []
            try:
                sample = cache.at(time)
            except ExtrapolationException as error:
                # The target may still be below this frame.
                obstacle = error
                break
            upwards.append(sample)
            top = sample[1]
            cache = frames[top]
            if len(upwards) > _MAX_DEPTH:
                raise self._loop()
        downwards: list[Sample] = []
        frame = target
        while frame != top:
            if frame == source:
                return [], downwards
            cache = frames[frame]
            if cache is None:
                if obstacle is None:
                    raise _unconnected(target, source)
                raise _extrapolation(obstacle, target, source)
            try:
                sample = cache.at(time)
            except ExtrapolationException as error:
                raise _extrapolation(error, target, source) from None
            downwards.append(sample)
            frame = sample[1]
            if len(downwards) > _MAX_DEPTH:
                raise self._loop()
        return upwards, downwards

    def _latest_common_time(self, target: str, source: str) -> int:
        """Return the smallest of the newest stamps on the path [ns], 0 if all is static."""
        upwards: list[tuple[str, int]] = []
        latest = _NEVER
        frame = source
        while True:
            newest = self._newest(frame)
            if newest is None:
                break
            stamp, frame = newest[0], newest[1]
            if 0 < stamp < latest:
                latest = stamp
            if frame == target:
                return latest if latest != _NEVER else 0
            upwards.append((frame, stamp))
            if len(upwards) > _MAX_DEPTH:
                raise self._loop()
        parents = {parent for parent, _ in upwards}
        latest = _NEVER
        frame = target
        depth = 0
        while True:
            newest = self._newest(frame)
            if newest is None:
                raise _unconnected(target, source)
            stamp, frame = newest[0], newest[1]
            if 0 < stamp < latest:
                latest = stamp
            if frame in parents:
                break
            if frame == source:
                return latest if latest != _NEVER else 0
            depth += 1
            if depth > _MAX_DEPTH:
                raise self._loop()
        for parent, stamp in upwards:
            if 0 < stamp < latest:
                latest = stamp
            if parent == frame:
                break
        return latest if latest != _NEVER else 0

    def _newest(self, frame: str) -> Sample | None:
        cache = self._frames[frame]
        return None if cache is None else cache.newest()

    def _parent(self, frame: str) -> str | None:
        newest = self._newest(frame)
        return None if newest is None else newest[1]

    def _validate(self, function: str, frame: str) -> None:
        """Raise what is wrong with a frame's name."""
        if problem := problem_of_name(frame):
            raise InvalidArgumentException(
                f'Invalid argument "{frame}" passed to {function} - {problem}')
        if frame not in self._frames:
            raise LookupException(f'"{frame}" passed to {function} does not exist. ')

    def _validate_asked(self, **frames: str) -> None:
        """Raise what is wrong with the names that canTransform gets, in its words."""
        for argument, frame in frames.items():
            problem = problem_of_name(frame) or (
                '' if frame in self._frames else 'frame does not exist')
            if problem:
                raise LookupException(f'Invalid frame ID "{frame}" passed to canTransform '
                                      f'argument {argument} - {problem}')

    def _loop(self) -> LookupException:
        return LookupException('The tf tree is invalid because it contains a loop.\n'
                               f'{self.all_frames_as_string()}\n')

    def _frame_as_yaml(self, name: str) -> str:
        cache, parent = self._frames[name], self._parent(name)
        if cache is None or parent is None:
            return ''
        newest, oldest = cache.newest_stamp(), cache.oldest_stamp()
        rate = len(cache) * 1e9 / max(newest - oldest, _SHORTEST_SPAN)
        return (f'{name}: \n'
                f"  parent: '{parent}'\n"
                f"  broadcaster: '{self._authorities.get(name, 'no recorded authority')}'\n"
                f'  rate: {rate:.3f}\n'
                f'  most_recent_transform: {seconds(newest)}\n'
                f'  oldest_transform: {seconds(oldest)}\n'
                f'  buffer_length: {(newest - oldest) * 1e-9:.3f}\n')


def _unconnected(target: str, source: str) -> ConnectivityException:
    return ConnectivityException(
        f"Could not find a connection between '{target}' and '{source}' because they are not part "
        'of the same tree.Tf has two or more unconnected trees.')


def _extrapolation(error: ExtrapolationException, target: str,
                   source: str) -> ExtrapolationException:
    return ExtrapolationException(
        f'{error}, when looking up transform from frame [{source}] to frame [{target}]')
