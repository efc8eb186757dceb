# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What cameras publish, as a client sees it beside a stack in real time."""

from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from numpy.typing import NDArray
import pytest
from rclpy.qos import qos_profile_sensor_data, QoSReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from tf2_msgs.msg import TFMessage
from world_user import OK, READY, START_TIMEOUT, WorldUser

from armsim_ros.clients.client_node import ClientNode, LATCHED
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.testing.program import private_domain, start_program

#: Pictures are drawn only when nothing else wants the processor.
pytestmark = pytest.mark.alone
statement = pytest.mark.statement
OPTICAL = 'camera_color_optical_frame'
FRONT = ('{simulation.cameras.front: {link: world, xyz: [2.0, 0.0, 1.5], rpy: [0.0, 0.1, 3.1416], '
         'width: 160, height: 120, rate: 5}}')
BALL = 'armsim://sphere?radius=0.02&color=1,0,1'
#: For a picture drawn at the lowest priority [s].
PATIENCE = 120.0


@pytest.fixture(scope='module')
def seen(drawing: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[WorldUser]:
    """Start a stack with two cameras."""
    with private_domain() as domain, start_program(
        'bringup', domain, 'world:=feeding_place', 'camera:=true', f'overrides:={FRONT}',
    ) as program:
        program.wait_for_line(READY, START_TIMEOUT)
        program.wait_for_line(r'cameras: camera, front; drawn by', PATIENCE)
        with ClientNode(domain, 'camera_user') as client:
            yield WorldUser(client, program, tmp_path_factory.mktemp('camera'))


def pixels(message: Image) -> NDArray[Any]:
    """Return a picture as an array."""
    kind, depth = (np.uint8, 3) if message.encoding == 'rgb8' else (np.float32, 1)
    content = np.frombuffer(message.data, kind)
    return content.reshape(message.height, message.width, depth).squeeze()


def pair(world: WorldUser, first: str, second: str, kinds: tuple[type, type]) -> tuple[Any, Any]:
    """Return two messages of one stamp; their topics came after this call."""
    collectors = [world.client.collect(topic, kind)
                  for topic, kind in zip((first, second), kinds, strict=True)]
    try:
        collectors[0].wait(2, PATIENCE)
        found: dict[int, Any] = {}

        def has_partner(message: Any) -> bool:
            stamp = ns_from_time(message.header.stamp)
            found.update((stamp, one) for one in collectors[1].messages
                         if ns_from_time(one.header.stamp) == stamp)
            return stamp in found

        message = collectors[0].wait_for(has_partner, PATIENCE)
        return message, found[ns_from_time(message.header.stamp)]
    finally:
        for one in collectors:
            one.close()


def rendering_status(world: WorldUser) -> Any:
    """Return the next status of the program that draws."""
    diagnostics = world.client.collect('/diagnostics', DiagnosticArray)
    try:
        message = diagnostics.wait_for(
            lambda one: one.status[0].name == 'camera: Rendering', PATIENCE)
        return message.status[0]
    finally:
        diagnostics.close()


@statement('E1', 'E2')
def test_pictures_have_their_infos_frames_and_one_stamp(seen: WorldUser) -> None:
    """Colour is rgb8, depth 32FC1 in metres; both are 640x480 in the optical frame."""
    colour, depth = pair(seen, '/camera/color/image_raw', '/camera/depth/image_raw',
                         (Image, Image))
    assert (colour.encoding, depth.encoding) == ('rgb8', '32FC1')
    for picture in (colour, depth):
        assert (picture.width, picture.height) == (640, 480)
        assert picture.header.frame_id == OPTICAL
    _, info = pair(seen, '/camera/depth/image_raw', '/camera/depth/camera_info',
                   (Image, CameraInfo))
    assert info.header.frame_id == OPTICAL
    assert (info.distortion_model, list(info.d)) == ('plumb_bob', [0.0] * 5)
    assert list(info.r) == [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    assert [*info.p[:3], *info.p[4:7], *info.p[8:11]] == list(info.k)
    assert info.k[0] == info.k[4] == pytest.approx(1043.99 * 480 / 1080, abs=0.01)


@statement('E1')
def test_frames_of_the_cameras_are_static_transforms(seen: WorldUser) -> None:
    """Those that the URDF has, and those of a camera that stands elsewhere."""
    collector = seen.client.collect('/tf_static', TFMessage, LATCHED)
    wanted = {'camera_link', OPTICAL, 'front_link', 'front_color_optical_frame'}
    collector.wait_for(lambda _: wanted <= {
        one.child_frame_id for message in collector.messages for one in message.transforms})
    collector.close()


@statement('E2')
def test_a_known_point_is_seen_at_its_pixel_and_depth(seen: WorldUser) -> None:
    """Within a pixel and 4 mm; the ball is put into the camera's frame."""
    x, y, z, radius = 0.06, -0.04, 0.35, 0.02
    assert seen.spawn('ball', (x, y, z), BALL, frame=OPTICAL).result.result == OK
    colours = seen.client.collect('/camera/color/image_raw', Image)
    depths = seen.client.collect('/camera/depth/image_raw', Image)

    def magenta(message: Image) -> NDArray[Any]:
        red, green, blue = np.moveaxis(pixels(message).astype(int), -1, 0)
        return (red - green > 60) & (blue - green > 60)

    colour = colours.wait_for(lambda message: magenta(message).any(), PATIENCE)
    depth = depths.wait_for(lambda message: message.header.stamp == colour.header.stamp, PATIENCE)
    colours.close()
    depths.close()
    focal = 1043.99 * 480 / 1080
    u, v = focal * x / z + 319.5, focal * y / z + 239.5
    lines, columns = np.nonzero(magenta(colour))
    distance = float(np.linalg.norm((x, y, z)))
    assert abs(columns.mean() - u) < 1.0
    assert abs(lines.mean() - v) < 1.0
    assert abs(pixels(depth)[round(v), round(u)] - z * (1.0 - radius / distance)) < 0.004
    assert seen.result('delete_entity', entity='ball')[0] == OK


@statement('E1')
def test_depth_out_of_range_is_infinite(seen: WorldUser) -> None:
    """Nothing hit is +inf; what is nearer than the range is -inf."""
    assert seen.spawn('near', (0.0, 0.0, 0.06), 'armsim://sphere?radius=0.01',
                      frame=OPTICAL).result.result == OK
    depths = seen.client.collect('/camera/depth/image_raw', Image)
    depths.wait_for(lambda message: bool(np.isneginf(pixels(message)[240, 320])), PATIENCE)
    assert np.isposinf(pixels(depths.messages[-1])).any()
    depths.close()
    assert seen.result('delete_entity', entity='near')[0] == OK


@statement('E3')
def test_publishers_are_reliable_and_match_best_effort(seen: WorldUser) -> None:
    """A subscription with the profile of sensors gets pictures."""
    node = seen.client.node
    (info,) = node.get_publishers_info_by_topic('/front/color/image_raw')
    assert info.qos_profile.reliability == QoSReliabilityPolicy.RELIABLE
    pictures = seen.client.collect('/front/color/image_raw', Image, qos_profile_sensor_data)
    pictures.wait(1, PATIENCE)
    pictures.close()


@statement('E3')
def test_what_nobody_wants_is_not_drawn(seen: WorldUser) -> None:
    """The count of pictures stands still, also where only the infos are wanted."""
    infos = seen.client.collect('/camera/color/camera_info', CameraInfo)
    infos.wait(1, PATIENCE)
    before = drawn(seen)
    infos.clear()
    infos.wait(3, PATIENCE)
    assert drawn(seen) == before
    infos.close()


def drawn(world: WorldUser) -> int:
    """Return how many pictures were drawn."""
    return int({one.key: one.value for one in rendering_status(world).values}['pictures'])


@statement('E4')
def test_pictures_are_drawn_by_a_process_of_the_lowest_priority(seen: WorldUser) -> None:
    """It is a child of bringup; all threads that draw give way to everybody."""
    pid = seen.program.process.pid
    children = map(int, Path(f'/proc/{pid}/task/{pid}/children').read_text().split())
    (camera,) = (child for child in children if 'camera' in Path(
        f'/proc/{child}/cmdline').read_text().split('\0')[:6])
    assert os.getpriority(os.PRIO_PROCESS, camera) == 19
    for thread in Path(f'/proc/{camera}/task').iterdir():
        if 'llvmpipe' in (thread / 'comm').read_text():
            assert os.getpriority(os.PRIO_PROCESS, int(thread.name)) == 19


@statement('E7')
def test_points_are_organised_and_agree_with_the_depth(seen: WorldUser) -> None:
    """One point a pixel; z is the depth, NaN where there is none."""
    cloud, depth = pair(seen, '/camera/depth/points', '/camera/depth/image_raw',
                        (PointCloud2, Image))
    assert (cloud.width, cloud.height, cloud.header.frame_id) == (640, 480, OPTICAL)
    assert [one.name for one in cloud.fields] == ['x', 'y', 'z', 'rgb']
    points = np.frombuffer(cloud.data, np.float32).reshape(480, 640, -1)
    depth_values = pixels(depth)
    finite = np.isfinite(depth_values)
    np.testing.assert_array_equal(points[finite][:, 2], depth_values[finite])
    assert np.isnan(points[~finite][:, 2]).all()


@statement('E7')
def test_a_second_camera_has_its_own_topics(seen: WorldUser) -> None:
    """It has the size that its settings say, and sees the robot's table."""
    pictures = seen.client.collect('/front/color/image_raw', Image)
    picture = pictures.wait(1, PATIENCE)[-1]
    pictures.close()
    assert (picture.width, picture.height) == (160, 120)
    assert len(np.unique(pixels(picture).reshape(-1, 3), axis=0)) > 3


@statement('E5')
def test_where_nothing_can_draw_all_else_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """One line names the packages, diagnostics have an error, planning is ready."""
    monkeypatch.setenv('MUJOCO_GL', 'nothing')
    with private_domain() as domain, start_program(
        'bringup', domain, 'world:=feeding_place', 'camera:=true'
    ) as program:
        program.wait_for_line(READY, START_TIMEOUT)
        program.wait_for_line(
            r'\[camera\].*no pictures: .*libegl1 libegl-mesa0 libgl1-mesa-dri, or libosmesa6',
            PATIENCE)
        with ClientNode(domain, 'camera_user') as client:
            world = WorldUser(client, program, Path())
            status = rendering_status(world)
            assert status.level == status.ERROR
            assert 'libosmesa6' in status.message
            assert 'sunday' in world.entities()
        assert program.stop() == 0


@statement('E1')
def test_a_robot_without_cameras_says_so() -> None:
    """The message says where they are written."""
    with private_domain() as domain, start_program(
        'simulation', domain, 'robot:=ur5', 'camera:=true'
    ) as program:
        program.wait_for_line("'ur5' has none under 'cameras' in its simulation.yaml", 60.0)
        assert program.wait(30.0) == 2
