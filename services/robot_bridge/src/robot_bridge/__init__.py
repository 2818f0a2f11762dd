"""The one hand on the robot: everything that moves it or reads its sensors passes through here."""
