"""What moves or is seen apart: eyes, lids, lashes, mouth, teeth, and expressions."""
