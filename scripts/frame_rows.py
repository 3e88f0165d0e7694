"""The arrays of a frame of frames.h5 with a row for each body that the scene may have, whether or not bodies come and go in it."""
import numpy as np


def rows_of(file, frame, name):
    """Row k is body k, of reals; NaN where it is absent."""
    values = frame[name][:]
    if 'id' not in frame:
        return values.astype(float)
    rows = np.full((len(file['bodies/id']), *values.shape[1:]), np.nan)
    rows[frame['id'][:]] = values
    return rows
