"""The shape space: MakeHuman's fields, the mesh, and which anatomy a person draws."""
