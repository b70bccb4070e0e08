"""What happened in a mission, written down as it happens: MCAP, .tlog and a digest."""
