"""From a camera frame to detections: the loop, the models, the boxes."""
