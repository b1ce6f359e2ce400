# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Recordings: rosbag2 bags in MCAP files, written, read, checked, restored and compared without ROS.

A tick goes `packing` -> `batch` -> `bag_writer` -> `chunk_queue` -> `chunk` -> `mcap_file`; a file
comes back through `mcap_scan` and `bag_reader`.
"""
