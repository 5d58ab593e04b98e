"""The ROS 2 node. Nothing outside this room imports ROS."""
