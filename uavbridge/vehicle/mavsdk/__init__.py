"""The second driver: MAVSDK 4 behind the vehicle seam, over our own links."""
