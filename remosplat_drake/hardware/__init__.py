"""The real robot: the wire, our end of it, its drivers and their stand-in."""
