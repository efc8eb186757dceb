"""Build of ROS interface packages without CMake: generators from PyPI wheels, then a compiler."""
