"""Types of arrays."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = float | NDArray[Any]  # a number, or an array of numbers
EPSILON = float(np.finfo(float).eps)
