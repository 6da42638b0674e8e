"""From pixels to rays."""
