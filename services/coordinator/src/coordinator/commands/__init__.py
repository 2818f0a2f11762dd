"""What a person may ask for, and what its turn is next: missions, pause, cancel, stop, the way to the dock."""
