"""What drives the wheels: leases and their arbiter, closed-loop motions, sessions, the one publisher of cmd_vel."""
