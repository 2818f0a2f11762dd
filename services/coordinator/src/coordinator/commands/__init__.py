"""What a person may ask for: to start, pause, resume and cancel missions, to stop, to wait."""
