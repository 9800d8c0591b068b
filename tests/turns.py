"""Oscillations of turns of the motor, from the samples of a motion alone."""

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.ndimage import maximum_filter1d, minimum_filter1d


def sizes_of_turns(error, places):
    """Largest |error - mean| over the turn of the motor from each sample, but the last turn."""
    total, half = cumulative_simpson(error, dx=1.0 / places, initial=0.0), places // 2
    means = total[places:] - total[:-places]
    top, bottom = (size(error, places + 1)[half:-half] for size in (maximum_filter1d, minimum_filter1d))
    return np.maximum(top - means, means - bottom)
