"""Rigid transforms of points and bodies, written into given arrays."""

from remosplat_drake.base.kernels import helper


@helper
def vector_to_world(X_WA, v, v_W):
    """Transforms a vector from A to W, shape (3,)."""
    for r in range(3):
        v_W[r] = X_WA[r, 0] * v[0] + X_WA[r, 1] * v[1] + X_WA[r, 2] * v[2]


@helper
def point_to_world(X_WA, p, p_W):
    """Transforms a point from A to W, shape (3,) [m]."""
    vector_to_world(X_WA, p, p_W)
    for r in range(3):
        p_W[r] += X_WA[r, 3]


@helper
def turn_body(R, center, X_WB, X):
    """Writes the pose of a body that is rotated about a point, (4, 4)."""
    for r in range(3):
        for c in range(3):
            X[r, c] = 0.0
            for k in range(3):
                X[r, c] += R[r, k] * X_WB[k, c]
        X[r, 3] = center[r]
        for k in range(3):
            X[r, 3] += R[r, k] * (X_WB[k, 3] - center[k])
    X[3, 0] = X[3, 1] = X[3, 2] = 0.0
    X[3, 3] = 1.0


@helper
def turn_back(R, center, p_W):
    """Maps a point of the rotated body back to the unrotated body."""
    x, y, z = p_W[0] - center[0], p_W[1] - center[1], p_W[2] - center[2]
    for c in range(3):
        p_W[c] = center[c] + R[0, c] * x + R[1, c] * y + R[2, c] * z
