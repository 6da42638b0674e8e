"""The frozen scene, its tables and how to build and store one."""
