"""Makes small images larger: bicubic, SRCNN and SRCNN twice, behind one call."""
