"""What is painted on a head: pigments, marks, lines, brows, beard, make-up, relief and sheen."""
