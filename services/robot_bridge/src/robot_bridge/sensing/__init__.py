"""What the robot perceives: sensor readings, transforms, camera, depth, places of boxes; how old and how blind."""
