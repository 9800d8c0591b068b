"""Script of `mat_file`, for a process of its own: write the variables of a MAT-file, or the error, to its output."""

import pickle
import sys
from typing import Any

from scipy.io import loadmat


def variables_or_error(path: str) -> Any:
    """Variables by name, without dimensions of length 1; the error where SciPy cannot read them."""
    try:
        return loadmat(path, appendmat=False, squeeze_me=True, struct_as_record=False)
    except NotImplementedError:  # as SciPy says of MATLAB 7.3, which another reader takes
        return NotImplementedError()
    except Exception as error:  # whatever a damaged file makes SciPy raise
        return ValueError(str(error))


if __name__ == "__main__":
    pickle.dump(variables_or_error(sys.argv[1]), sys.stdout.buffer)
