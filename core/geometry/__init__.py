"""Where rays meet surfaces: the intersector, the hit and the medium around the ray."""
