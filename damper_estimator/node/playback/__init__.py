"""Recordings and simulated rides played to running nodes, in a ROS domain of their own."""
