# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the build of a package would install where, of packages that are not built."""
