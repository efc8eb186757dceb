# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Files of sensors, as users have them."""

#: With the keys that MoveIt's Setup Assistant writes.
USUAL = """
sensors: [kinect_pointcloud, kinect_depthimage]
octomap_resolution: 0.02
octomap_frame: odom_combined
kinect_pointcloud:
  sensor_plugin: occupancy_map_monitor/PointCloudOctomapUpdater
  point_cloud_topic: /head_mount_kinect/depth_registered/points
  max_range: 5
  point_subsample: 2
  padding_offset: 0.1
  padding_scale: 1.0
  max_update_rate: 1.0
  filtered_cloud_topic: filtered_cloud
kinect_depthimage:
  sensor_plugin: occupancy_map_monitor/DepthImageOctomapUpdater
  image_topic: /head_mount_kinect/depth_registered/image_raw
  queue_size: 5
  near_clipping_plane_distance: 0.3
  far_clipping_plane_distance: 5.0
  shadow_threshold: 0.2
  padding_scale: 4.0
  padding_offset: 0.03
  max_update_rate: 1.0
  filtered_cloud_topic: filtered_cloud
"""
