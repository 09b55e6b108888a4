"""The RGB-D camera that the robot carries, real or simulated.

`WristCameraConfig` defines the camera's pose on the robot and its lens.
`CameraMount` computes the camera's pose X_WC from this and a configuration q,
and masks the robot's own pixels (`robot_mask`). A camera provides an
`RgbdImage`. An image with its pose, in which the robot is masked, is a `Frame`
of `capture.frames`.

There are six sources of images:

| Source                            | Name                             |
|-----------------------------------|----------------------------------|
| Simulated, inside the diagram     | `WristCameraConfig.AddToStation` |
| Simulated, in the mapping process | `RenderedCamera`                 |
| Simulated driver, sends by LCM    | `CameraSim`                      |
| Real or simulated, over LCM       | `LcmCamera`                      |
| Intel RealSense, by USB           | `RealSenseCamera`                |
| Its driver, sends by LCM          | `CameraDriver`                   |

The live map takes its pictures with a `WristCamera`: a `RenderedCamera` or an
`LcmCamera`. `MotionHistory` provides the robot's configuration at the time of
an image from `LcmCamera`. `CameraScene` renders the images of `RenderedCamera`
and `CameraSim`.

Two modules are for your own programs, and no command uses them. `live_frames`
collects a capture from a station's camera or from another camera, for example a
RealSense. `hand_eye_calibration` estimates the camera's pose on the robot from
the images of such a capture, without a calibration board.
"""
