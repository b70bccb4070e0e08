"""Watching a mission in the browser; needs the extra ``web`` (``pip install "uavbridge[web]"``)."""
