"""Driver processes: what stands between the station's wire and a robot."""
