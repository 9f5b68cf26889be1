"""How is a result told? One writer of pages, its figures and its words."""
