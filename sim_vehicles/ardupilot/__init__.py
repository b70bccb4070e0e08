"""The face of ArduPilot: its modes, parameters, texts, and what it does otherwise than PX4."""
