"""What emits light: lamps, emissive faces and the world, one file per kind."""
