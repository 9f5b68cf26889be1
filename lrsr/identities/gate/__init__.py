"""Which faces pass as human: measures, limits, and what is drawn again."""
