"""What may a network be told beside the difference of pixels? Terms of a weighted sum."""
