"""A robot's files as ROS has them, made into a description of ours."""
