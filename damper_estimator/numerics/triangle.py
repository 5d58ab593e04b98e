"""Reduces a tall matrix to a triangle with the same normal equations."""

import numpy as np

_PIECE = 8000  # matrix elements reduced at a time; OpenBLAS starts threads above 9216


def triangle(matrix: np.ndarray) -> np.ndarray:
    """R (k, k) of the QR decomposition of a tall matrix (m, k): all that its m rows determine about k unknowns.

    It is reduced in pieces, and the pieces again, each so small that the linear algebra library starts no
    threads. Triangles of parts, one below the other, have the same triangle as the whole (Demmel et al. 2012, TSQR).
    """
    count = matrix.shape[1]
    length = max(_PIECE // count, 2 * count)
    while matrix.shape[0] > length:
        pieces = -(-matrix.shape[0] // length)
        padded = np.zeros((pieces * length, count))
        padded[: matrix.shape[0]] = matrix
        matrix = np.linalg.qr(padded.reshape(pieces, length, count), mode="r").reshape(-1, count)
    return np.linalg.qr(matrix, mode="r")
