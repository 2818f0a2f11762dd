"""The robot from a terminal: `atom find "red bottle"`, `atom stop`, `atom status`, `atom memory`."""
