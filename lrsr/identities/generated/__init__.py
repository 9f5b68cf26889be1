"""Faces that a network makes: people for :mod:`lrsr.identities.photographs` whom nobody met."""
