"""What has been rendered so far, and how wrong it still is."""
