"""A slow, unbiased path tracer: the second opinion of the tests, never a renderer."""
