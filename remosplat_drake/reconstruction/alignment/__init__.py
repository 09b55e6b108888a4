"""Camera poses, depth scale and offset, refined from what the sensor gave."""
