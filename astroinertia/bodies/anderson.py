"""Anderson's acceleration of a fixed-point iteration.

Sources: Anderson 1965, J. ACM 12, 547; Walker & Ni 2011, SIAM J. Numer. Anal. 49, 1715. Tests:
tests/unit/bodies/test_scf.py, tests/unit/bodies/test_figures.py.
"""

import numpy as np

_RANK = 1e-12  # share of the largest singular value below which changes count as the same


class Anderson:
    """The next iterate from the last few and what the map made of them, by least squares on their changes.

    depth: how many earlier iterates are mixed in.
    """

    def __init__(self, depth: int) -> None:
        self.depth = depth
        self._images: list[np.ndarray] = []
        self._residuals: list[np.ndarray] = []

    def next(self, state: np.ndarray, image: np.ndarray) -> np.ndarray:
        """Return the next iterate, from the present one and its image under the map, of one shape."""
        residual = (image - state).ravel()
        self._images = [*self._images[-self.depth :], image.ravel()]
        self._residuals = [*self._residuals[-self.depth :], residual]
        if len(self._residuals) == 1:
            return image
        changes = np.diff(np.array(self._residuals), axis=0)
        weights = np.linalg.lstsq(changes.T, residual, rcond=_RANK)[0]
        return (image.ravel() - weights @ np.diff(np.array(self._images), axis=0)).reshape(image.shape)
