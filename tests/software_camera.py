"""A camera of librealsense that is fed with images: no hardware is needed."""

import numpy as np

WIDTH, HEIGHT = 64, 48
BASELINE = 0.05
UNIT = 0.00025
"""As of a D405; most models count millimetres."""


class SoftwareCamera:
    """Feeds librealsense frames; the colour lens sits beside the depth's."""

    def __init__(self, rs):
        self.rs = rs
        self.device = rs.software_device()
        self.depth = self.device.add_sensor("Depth")
        self.color = self.device.add_sensor("Color")
        self.depth.add_read_only_option(rs.option.depth_units, UNIT)
        self.depth_stream = self.depth.add_video_stream(
            self.stream(0, rs.stream.depth, rs.format.z16, 2)
        )
        self.color_stream = self.color.add_video_stream(
            self.stream(1, rs.stream.color, rs.format.rgb8, 3)
        )
        beside = rs.extrinsics()
        beside.rotation = np.eye(3).ravel().tolist()
        beside.translation = [BASELINE, 0, 0]
        self.depth_stream.register_extrinsics_to(self.color_stream, beside)
        self.device.create_matcher(rs.matchers.default)
        self.syncer = rs.syncer()
        for sensor, stream in self.sensors():
            sensor.open(stream)
            sensor.start(self.syncer)

    def sensors(self):
        return (self.depth, self.depth_stream), (self.color, self.color_stream)

    def stream(self, uid, kind, format, bytes_per_pixel):
        stream = self.rs.video_stream()
        stream.uid, stream.type, stream.fmt = uid, kind, format
        stream.width, stream.height, stream.fps = WIDTH, HEIGHT, 30
        stream.bpp = bytes_per_pixel
        stream.intrinsics = intrinsics(self.rs)
        return stream

    def frames(self, depth, rgb):
        """A pair; the matcher may let single images pass at first."""
        for number in range(20):
            for (sensor, stream), pixels, size in zip(
                self.sensors(), (depth, rgb), (2, 3), strict=True
            ):
                frame = self.rs.software_video_frame()
                frame.pixels, frame.bpp = pixels, size
                frame.stride = WIDTH * size
                frame.timestamp = 1000.0 + 33.0 * number
                frame.domain = self.rs.timestamp_domain.system_time
                frame.frame_number = number
                frame.profile = stream.as_video_stream_profile()
                frame.depth_units = UNIT
                sensor.on_video_frame(frame)
            frames = self.syncer.wait_for_frames(2000)
            if frames.size() == 2:
                return frames
        raise AssertionError("librealsense matched no two images")

    def stop(self):
        for sensor, _ in self.sensors():
            sensor.stop()
            sensor.close()


def intrinsics(rs, model="inverse_brown_conrady", coefficients=(0.0,) * 5):
    values = rs.intrinsics()
    values.width, values.height = WIDTH, HEIGHT
    values.fx, values.fy, values.ppx, values.ppy = 60.0, 61.0, 31.5, 23.5
    values.model = getattr(rs.distortion, model)
    values.coeffs = list(coefficients)
    return values
