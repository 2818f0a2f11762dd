"""What people's words mean, by rules: orders to stop, moods, restrictions. Pure; needs no other service."""
