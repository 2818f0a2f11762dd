"""Messages, topics and HTTP schemas shared by the services: data only, no I/O."""
