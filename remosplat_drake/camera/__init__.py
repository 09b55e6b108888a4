"""The RGB-D camera that the robot carries, real or simulated.

`WristCameraConfig` says where it sits on the robot and what its lens is;
`CameraMount` turns that and a configuration q into the camera's pose X_WC, and
hides the robot's own pixels (`robot_mask`). What a camera delivers is an
`RgbdImage`; an image with its pose, the robot hidden, is a `Frame` of
`capture.frames`.

There are six ways to an image:

| Who takes it                      | Name                             |
|-----------------------------------|----------------------------------|
| Simulated, inside the diagram     | `WristCameraConfig.AddToStation` |
| Simulated, in the mapping process | `RenderedCamera`                 |
| Simulated driver, sends by LCM    | `CameraSim`                      |
| Real or simulated, heard by LCM   | `LcmCamera`                      |
| Intel RealSense, by USB           | `RealSenseCamera`                |
| Its driver, sends by LCM          | `CameraDriver`                   |

The live map takes its pictures with a `WristCamera`, which `RenderedCamera`
and `LcmCamera` are. `MotionHistory` knows where the robot was when an image
that `LcmCamera` hears was taken; `CameraScene` renders for `RenderedCamera`
and `CameraSim`.

Two modules are for programs of your own, and no run uses them: `live_frames`
collects a capture from a station's camera or from any other, a RealSense for
example, and `hand_eye_calibration` finds the camera's pose on the robot from
such images alone.
"""
