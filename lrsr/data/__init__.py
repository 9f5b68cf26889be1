"""Renders what an experiment needs, keeps it, and serves it as pairs of tensors."""
