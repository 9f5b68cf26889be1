"""lrsr: what can still be recognised in a face ten pixels wide, and does super-resolution help?

Importing this package is cheap: every part (and the heavy library at home in it) is imported by
name, as in ``from lrsr.rendering import render``.
"""

__version__ = "0.2.0"
