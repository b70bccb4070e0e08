"""MAVLink client: links, protocol machines, flavours of autopilot."""
