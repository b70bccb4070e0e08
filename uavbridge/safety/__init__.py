"""The last word before a setpoint leaves: fence, altitude band, speed, separation."""
