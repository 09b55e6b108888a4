"""The robot: its model, spheres and kinematics."""
