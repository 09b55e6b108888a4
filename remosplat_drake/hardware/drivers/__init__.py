"""Driver processes: what stands between the wire and a robot."""
