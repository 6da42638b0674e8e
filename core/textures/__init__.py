"""What varies over a surface: images, their coordinates and shader nodes."""
