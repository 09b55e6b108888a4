"""Grasps for parallel grippers: antipodal candidates on surfaces, ranked."""
