"""Hair: a style, a colour, a shell of combed strands and ribbons on it."""
