"""Plans grasps for parallel grippers: ranked antipodal pairs on surfaces."""
