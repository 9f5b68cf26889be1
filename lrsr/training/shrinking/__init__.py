"""From a sharp picture to the small one that a network is given: one way a module."""
