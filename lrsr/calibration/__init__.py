"""From pictures back to the camera that took them: what lrsr fit-camera is made of."""
