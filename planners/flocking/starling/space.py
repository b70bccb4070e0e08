"""Safe and danger space, by local messages (Chen 2023, section 2.1, Fig. 3).

Every aircraft knows how long ago the last disturbance was that it has heard of. One that is
disturbed sets it to zero; a message takes it one hop further at every update, with its age.
"""

from __future__ import annotations

import numpy as np

from planners.types import F64, Bools


def heard(age_s: F64, disturbed: Bools, visible: Bools, step_s: float) -> F64:
    """Ages (..., n) of the last disturbance known, one update later.

    Args:
        age_s: (..., n) before; inf when there has been none.
        disturbed: (..., n) who is disturbed now.
        visible: (..., n, n) who hears whom.
        step_s: time since the last update.
    """
    theirs = np.where(visible, age_s[..., None, :], np.inf).min(axis=-1, initial=np.inf)
    return np.where(disturbed, 0.0, np.minimum(age_s, theirs) + step_s)
