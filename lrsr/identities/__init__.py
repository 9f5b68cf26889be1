"""Who is in the picture: synthetic heads, each made from a seed."""
