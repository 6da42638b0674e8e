"""Photon maps kept in a file, for renders that differ in nothing but the camera."""
