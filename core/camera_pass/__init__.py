"""The camera pass: paths from the lens to the first wide scatterer, and its light."""
