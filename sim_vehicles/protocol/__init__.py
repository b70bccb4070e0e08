"""What vehicles do with the MAVLink packets they get: sans I/O, packets in, frames out."""
