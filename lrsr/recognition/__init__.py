"""From an image and five landmarks to an embedding, and from embeddings to scores."""
