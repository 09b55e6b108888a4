"""The camera that the robot carries: its mount, its images, its sources."""
