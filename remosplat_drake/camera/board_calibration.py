"""Hand-eye calibration from images of a fixed ChArUco board.

A camera C is fixed to a frame F of the robot, and a board K to the world W. The
poses X_FC and X_WK are unknown. The calibration minimises the reprojection
error of the board's corners,

    min over X_FC, X_WK of sum |pi(X_CF X_FW X_WK p_KQ) - z|^2,

with X_WF from the robot's kinematics. The iteration starts from the closed-form
solution of A_i X = X B_i by Park and Martin (1994), where A_i are the motions
of F, and B_i the motions of the camera relative to the board. So no initial
value of X_FC is needed.
"""

import dataclasses as dc
import re

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.camera.hand_eye_calibration import check_turns, transform
from remosplat_drake.capture.capture import Capture

_FEWEST_CORNERS, _FEWEST_IMAGES = 6, 5
_WORST = 2.0
"""A fit is rejected if the RMS distance between detected and projected corners
exceeds this [pixels]."""


@dc.dataclass(frozen=True)
class CharucoBoard:
    """A chessboard with a marker in each white square.

    Attributes:
        columns: Number of squares along the board's x axis.
        rows: Number of squares along the board's y axis.
        square: Side of a square [m].
        marker: Side of a marker [m].
        dictionary: OpenCV's name of the markers, such as DICT_4X4_50.
    """

    columns: int
    rows: int
    square: float
    marker: float
    dictionary: str = "DICT_4X4_50"

    @staticmethod
    def parse(text: str) -> "CharucoBoard":
        """Reads a board written COLUMNSxROWS:SQUARE:MARKER[:DICTIONARY].

        Args:
            text: For example `7x5:0.04:0.03`, lengths in metres.

        Raises:
            RemoSplatError: The text has another format.
        """
        number = r"(\d*\.?\d+)"
        match = re.fullmatch(rf"(\d+)x(\d+):{number}:{number}(?::(\w+))?", text)
        if match is None:
            raise RemoSplatError(
                f"--board: {text!r}: expected"
                " COLUMNSxROWS:SQUARE:MARKER[:DICTIONARY], lengths in metres"
            )
        columns, rows, square, marker, dictionary = match.groups()
        board = CharucoBoard(
            int(columns), int(rows), float(square), float(marker)
        )
        if not (
            0 < board.marker < board.square
            and min(board.columns, board.rows) > 2
        ):
            raise RemoSplatError(
                f"--board: {text!r}: needs at least three columns and rows,"
                " and markers smaller than the squares"
            )
        return dc.replace(board, dictionary=dictionary or board.dictionary)

    def opencv(self):
        """Converts the board to OpenCV's `CharucoBoard`.

        Raises:
            MissingExtraError: OpenCV is not installed.
            RemoSplatError: OpenCV has no dictionary of this name, or the
                dictionary has too few markers.
        """
        aruco = _opencv().aruco
        number = getattr(aruco, self.dictionary, None)
        if not isinstance(number, int):
            raise RemoSplatError(
                f"--board: unknown dictionary {self.dictionary!r}; valid: "
                + ", ".join(n for n in dir(aruco) if n.startswith("DICT_"))
            )
        markers = aruco.getPredefinedDictionary(number)
        if self.columns * self.rows // 2 > len(markers.bytesList):
            raise RemoSplatError(
                f"--board: {self.dictionary} has too few markers for the board"
            )
        return aruco.CharucoBoard(
            (self.columns, self.rows), self.square, self.marker, markers
        )


@dc.dataclass(frozen=True, eq=False)
class BoardView:
    """The board's corners in one image.

    Attributes:
        X_WF: Pose of the frame that carries the camera, shape (4, 4).
        K: Intrinsic matrix, shape (3, 3) [pixels].
        p_KQ: Positions of the corners in the board's frame, shape (n, 3) [m].
        z: Positions of the corners in the image, shape (n, 2) [pixels].
        X_CK: Pose of the board in the camera's frame, estimated from this image
            alone, shape (4, 4).
    """

    X_WF: np.ndarray
    K: np.ndarray
    p_KQ: np.ndarray
    z: np.ndarray
    X_CK: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class BoardFit:
    """A hand-eye transform, with its uncertainty.

    Attributes:
        X_FC: The camera's pose (OpenCV axes) in the frame F that carries it.
        X_WK: Pose of the board in W.
        residual: RMS distance between detected and projected corners [pixels].
        images: Number of images that show the board.
        turn_deviation: Standard deviation of the rotation about its least
            certain axis [rad], from the scatter between images.
        deviation: Standard deviation of the translation along its least certain
            axis [m], from the scatter between images.
    """

    X_FC: np.ndarray
    X_WK: np.ndarray
    residual: float
    images: int
    turn_deviation: float
    deviation: float


def find_board(
    board: CharucoBoard, capture: Capture, X_FC: np.ndarray
) -> list[BoardView]:
    """Finds the board in images of a robot's camera.

    Args:
        board: The board.
        capture: Images at poses X_WC = X_WF X_FC, with X_WF from the robot's
            kinematics.
        X_FC: The hand-eye transform in these poses, shape (4, 4).

    Returns:
        A view of each image that shows enough of the board.
    """
    cv = _opencv()
    detector = cv.aruco.CharucoDetector(board.opencv())
    corners_K = np.asarray(detector.getBoard().getChessboardCorners(), float)
    views = []
    for K, X_WC, rgb in zip(capture.K, capture.X_WC, capture.rgb, strict=True):
        grey = cv.cvtColor(np.ascontiguousarray(rgb), cv.COLOR_RGB2GRAY)
        z, numbers, _, _ = detector.detectBoard(grey)
        if numbers is None or len(numbers) < _FEWEST_CORNERS:
            continue
        p_KQ = corners_K[np.ravel(numbers)]
        # In OpenCV the centre of the first pixel is (0, 0).
        z = np.reshape(z, (-1, 2)).astype(float) + 0.5
        found, turn, p = cv.solvePnP(p_KQ, z, K, None)
        if found:
            X_CK = transform(np.concatenate([np.ravel(turn), np.ravel(p)]))
            X_WF = X_WC @ np.linalg.inv(X_FC)
            views.append(BoardView(X_WF, K, p_KQ, z, X_CK))
    return views


def fit_board(views: list[BoardView]) -> BoardFit:
    """Computes the hand-eye transform from images of a fixed board.

    Args:
        views: The board's corners in several images.

    Raises:
        RemoSplatError: Too few images show the board, the camera rotated too
            little, or no fixed pose on the robot explains the images.
    """
    if len(views) < _FEWEST_IMAGES:
        raise RemoSplatError(
            f"hand-eye calibration: only {len(views)} images show the board; at"
            f" least {_FEWEST_IMAGES} are needed"
        )
    check_turns(np.stack([view.X_WF for view in views]))
    X_FC = _closed_form(views)
    X_WK = views[0].X_WF @ X_FC @ views[0].X_CK

    def residuals(x: np.ndarray) -> np.ndarray:
        X, Y = X_FC @ transform(x[:6]), X_WK @ transform(x[6:])
        return np.concatenate([_offsets(view, X, Y) for view in views])

    fit = least_squares(residuals, np.zeros(12))
    rms = float(np.sqrt(2 * np.mean(fit.fun**2)))
    if rms > _WORST:
        raise RemoSplatError(
            f"hand-eye calibration: the corners are {rms:.1f} pixels off on"
            f" average, more than {_WORST:g}: check the board's dimensions, and"
            " that it did not move"
        )
    covariance = _covariance(fit.fun, fit.jac, [v.z.size for v in views])
    return BoardFit(
        X_FC=X_FC @ transform(fit.x[:6]),
        X_WK=X_WK @ transform(fit.x[6:]),
        residual=rms,
        images=len(views),
        turn_deviation=_largest(covariance[:3, :3]),
        deviation=_largest(covariance[3:6, 3:6]),
    )


def _covariance(r: np.ndarray, J: np.ndarray, sizes: list[int]) -> np.ndarray:
    """Covariance of the parameters, shape (12, 12).

    An error of the robot's pose moves all corners of an image together. So the
    covariance is computed from the scatter of whole images (the sandwich
    estimator of clustered data), and not from that of single corners.
    """
    ends = np.cumsum(sizes)[:-1]
    scores = np.stack(
        [
            J_i.T @ r_i
            for J_i, r_i in zip(
                np.split(J, ends), np.split(r, ends), strict=True
            )
        ]
    )
    n, unknowns = len(sizes), J.shape[1]
    bread = np.linalg.pinv(J.T @ J)
    # Each image determines six unknowns.
    shrinkage = 6 * n / max(1, 6 * n - unknowns)
    return shrinkage * bread @ (scores.T @ scores) @ bread


def _offsets(view: BoardView, X_FC: np.ndarray, X_WK: np.ndarray):
    """Differences between projected and detected corners [pixels]."""
    X_CK = np.linalg.solve(view.X_WF @ X_FC, X_WK)
    p_C = view.p_KQ @ X_CK[:3, :3].T + X_CK[:3, 3]
    depth = np.maximum(p_C[:, 2:], 1e-3)
    at = (p_C / depth) @ view.K.T
    return (at[:, :2] - view.z).ravel()


def _closed_form(views: list[BoardView]) -> np.ndarray:
    """Solves A X = X B for X_FC over all pairs of images (Park and Martin)."""
    A, B = [], []
    for i, a in enumerate(views):
        for b in views[i + 1 :]:
            A.append(np.linalg.solve(b.X_WF, a.X_WF))
            B.append(b.X_CK @ np.linalg.inv(a.X_CK))
    A, B = np.stack(A), np.stack(B)
    a = Rotation.from_matrix(A[:, :3, :3]).as_rotvec()
    b = Rotation.from_matrix(B[:, :3, :3]).as_rotvec()
    R = Rotation.align_vectors(a, b)[0].as_matrix()
    # R_A p + p_A = R p_B + p, for the position p of the camera in F.
    left = (A[:, :3, :3] - np.eye(3)).reshape(-1, 3)
    right = (B[:, :3, 3] @ R.T - A[:, :3, 3]).ravel()
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, np.linalg.lstsq(left, right, rcond=None)[0]
    return X


def _largest(covariance: np.ndarray) -> float:
    """Standard deviation along the least certain axis."""
    return float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))


def _opencv():
    return import_optional("cv2", "a calibration board", "calibration")
