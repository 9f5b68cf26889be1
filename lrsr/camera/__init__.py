"""From the light on the film to the stored file: exposure, encoding, compression."""
