"""From people and scenes to pictures: recipes, the cache of renderings, folders of photographs."""
