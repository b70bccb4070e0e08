"""The bus: local (stepped) or zenoh (live), and the emulated radio on top."""
