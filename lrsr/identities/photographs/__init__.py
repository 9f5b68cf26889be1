"""A photograph becomes a head: landmarks, a fit of the shape space, a texture without its light."""
