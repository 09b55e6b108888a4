"""Writes captures as other programs do, so that tests can read them back."""

import io
import json
import zipfile
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.readers.nerfstudio import write_capture

OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])


def save_image(path: Path, pixels: np.ndarray):
    from PIL import Image

    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path)


def save_depth(path: Path, depth: np.ndarray, unit: float = 1e-3):
    save_image(path, np.rint(depth / unit).astype(np.uint16))


def opencv_matrix(K: np.ndarray) -> np.ndarray:
    """K for pixels with centres at whole numbers."""
    return K - np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])


def quaternion_xyzw(X: np.ndarray) -> list[float]:
    return Rotation.from_matrix(X[:3, :3]).as_quat().tolist()


def rows_of(matrix: np.ndarray) -> str:
    return "".join(" ".join(map(repr, row.tolist())) + "\n" for row in matrix)


def write_instant_ngp(folder: Path, capture: Capture):
    """What instant-ngp's NeRFCapture script saves."""
    unit = 10 / 65535
    frames = []
    for i, X_WC in enumerate(capture.X_WC):
        K = capture.K[i]
        save_image(folder / f"images/{i}.png", capture.rgb[i])
        save_depth(folder / f"images/{i}.depth.png", capture.depth[i], unit)
        frames.append(
            {
                "file_path": f"images/{i}",
                "depth_path": f"images/{i}.depth.png",
                "transform_matrix": (X_WC @ OPENGL).tolist(),
                "fl_x": K[0, 0],
                "fl_y": K[1, 1],
                "cx": K[0, 2],
                "cy": K[1, 2],
                "w": capture.size[1],
                "h": capture.size[0],
            }
        )
    document = {
        "frames": frames,
        "integer_depth_scale": unit,
        "enable_depth_loading": True,
        "aabb_scale": 4,
        "scale": 0.33,
        "offset": [0.5, 0.5, 0.5],
    }
    (folder / "transforms.json").write_text(json.dumps(document))


def write_tum(folder: Path, capture: Capture):
    lists = {"rgb": [], "depth": [], "groundtruth": []}
    for i, X_WC in enumerate(capture.X_WC):
        color, depth = 100.0 + i, 100.004 + i
        save_image(folder / f"rgb/{color:.6f}.png", capture.rgb[i])
        save_depth(folder / f"depth/{depth:.6f}.png", capture.depth[i], 1 / 5e3)
        lists["rgb"].append(f"{color:.6f} rgb/{color:.6f}.png")
        lists["depth"].append(f"{depth:.6f} depth/{depth:.6f}.png")
        pose = [*X_WC[:3, 3].tolist(), *quaternion_xyzw(X_WC)]
        lists["groundtruth"].append(" ".join(map(repr, [depth, *pose])))
    for name, lines in lists.items():
        text = "\n".join(["# a comment", *lines, ""])
        (folder / f"{name}.txt").write_text(text)
    K = opencv_matrix(capture.K[0])
    (folder / "intrinsics.txt").write_text(rows_of(K))


def write_trajectory_log(folder: Path, capture: Capture):
    log = ""
    for i, X_WC in enumerate(capture.X_WC):
        save_image(folder / f"color/{i:05d}.png", capture.rgb[i])
        save_depth(folder / f"depth/{i:05d}.png", capture.depth[i])
        log += f"{i} {i} {i + 1}\n" + rows_of(X_WC)
    (folder / "trajectory.log").write_text(log)
    height, width = capture.size
    K = opencv_matrix(capture.K[0])
    camera = {
        "width": width,
        "height": height,
        "intrinsic_matrix": K.T.ravel().tolist(),
    }
    (folder / "camera_primesense.json").write_text(json.dumps(camera))


def write_seven_scenes(folder: Path, capture: Capture):
    for i, X_WC in enumerate(capture.X_WC):
        stem = folder / f"frame-{i:06d}"
        save_image(Path(f"{stem}.color.png"), capture.rgb[i])
        depth = np.rint(capture.depth[i] * 1000).astype(np.uint16)
        depth[depth == 0] = 65535
        save_image(Path(f"{stem}.depth.png"), depth)
        Path(f"{stem}.pose.txt").write_text(rows_of(X_WC))
    K = opencv_matrix(capture.K[0])
    (folder / "camera-intrinsics.txt").write_text(rows_of(K))


def record3d_members(
    capture: Capture, confidence: np.ndarray | None = None, shrink: int = 1
) -> dict[str, bytes]:
    """The files of an archive; depth is `shrink` times coarser than colour."""
    import lzfse
    from PIL import Image

    height, width = capture.size
    members = {}
    for i in range(len(capture)):
        file = io.BytesIO()
        Image.fromarray(capture.rgb[i]).save(file, "jpeg", quality=95)
        members[f"rgbd/{i}.jpg"] = file.getvalue()
        depth = capture.depth[i, ::shrink, ::shrink]
        depth = np.where(depth > 0, depth, np.nan).astype("<f4")
        members[f"rgbd/{i}.depth"] = lzfse.compress(depth.tobytes())
        if confidence is not None:
            packed = lzfse.compress(confidence.astype(np.uint8).tobytes())
            members[f"rgbd/{i}.conf"] = packed
    poses_gl = [X_WC @ OPENGL for X_WC in capture.X_WC]
    metadata = {
        "w": width,
        "h": height,
        "dw": width // shrink,
        "dh": height // shrink,
        "K": capture.K[0].T.ravel().tolist(),
        "poses": [[*quaternion_xyzw(X), *X[:3, 3].tolist()] for X in poses_gl],
        "fps": 60,
    }
    return members | {"metadata": json.dumps(metadata).encode()}


def write_record3d_export(folder: Path, capture: Capture):
    """The app's "EXR + JPG" export."""
    for name, data in record3d_members(capture).items():
        path = folder / name.replace("rgbd", "rgb")
        if name == "metadata":
            path = folder / "metadata.json"
        if not name.endswith(".depth"):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
    for i, depth in enumerate(capture.depth):
        save_exr(folder / f"depth/{i}.exr", np.where(depth > 0, depth, np.nan))


def save_exr(path: Path, depth: np.ndarray):
    import OpenEXR

    path.parent.mkdir(parents=True, exist_ok=True)
    header = {"type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"R": depth.astype(np.float32)}).write(str(path))


def write_archive(path: Path, members: dict[str, bytes]):
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)


def write_record3d(path: Path, capture: Capture):
    write_archive(path, record3d_members(capture))


def write_stray_scanner(
    folder: Path,
    capture: Capture,
    confidence: np.ndarray | None = None,
    shrink: int = 1,
    per_frame_cameras: bool = True,
):
    """Depth is `shrink` times coarser than colour."""
    header = "timestamp, frame, x, y, z, qx, qy, qz, qw"
    header += ", fx, fy, cx, cy" if per_frame_cameras else ""
    rows = [header]
    for i, X_WC in enumerate(capture.X_WC):
        K = capture.K[i]
        row = [i / 60, f"{i:06d}", *X_WC[:3, 3], *quaternion_xyzw(X_WC)]
        if per_frame_cameras:
            row += [K[0, 0], K[1, 1], K[0, 2], K[1, 2]]
        rows.append(", ".join(map(str, row)))
        depth = capture.depth[i, ::shrink, ::shrink]
        save_depth(folder / f"depth/{i:06d}.png", depth)
        if confidence is not None:
            levels = confidence.astype(np.uint8)
            save_image(folder / f"confidence/{i:06d}.png", levels)
    (folder / "odometry.csv").write_text("\n".join(rows) + "\n")
    matrix = [", ".join(map(str, row)) for row in capture.K[0]]
    (folder / "camera_matrix.csv").write_text("\n".join(matrix))
    write_video(folder / "rgb.mp4", capture.rgb)


def write_video(path: Path, rgb: np.ndarray):
    """A video without loss, unlike a phone's."""
    import av

    with av.open(str(path), "w") as video:
        stream = video.add_stream("libx264rgb", rate=60, options={"qp": "0"})
        stream.height, stream.width = rgb.shape[1:3]
        stream.pix_fmt = "rgb24"
        for image in rgb:
            frame = av.VideoFrame.from_ndarray(image, format="rgb24")
            video.mux(stream.encode(frame))
        video.mux(stream.encode())


WRITERS = {
    "nerfstudio": write_capture,
    "instant-ngp": write_instant_ngp,
    "tum": write_tum,
    "trajectory-log": write_trajectory_log,
    "7-scenes": write_seven_scenes,
    "record3d": write_record3d,
    "record3d-export": write_record3d_export,
    "stray-scanner": write_stray_scanner,
}
