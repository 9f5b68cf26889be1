"""From a picture to the faces on it: box, score and five landmarks each."""
