"""The vehicle seam and its implementations."""
