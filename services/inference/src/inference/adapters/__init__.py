"""The real things behind the ports: models, language models, the robot's camera."""
