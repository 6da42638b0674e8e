import bpy

settings = bpy.context.scene.photon_map

settings.passes = 16
settings.seconds = 10.0
settings.error_goal = 0.1
settings.adaptive = True
settings.photons_automatic = True
settings.photons_caustic = 100000
settings.photons_global = 100000
settings.caustic_radius = 2.0
settings.alpha = 2 / 3
settings.light_samples = 1
settings.gather_rays = 4
settings.camera_depth = 12
settings.photon_depth = 12
settings.min_throughput = 0.001
settings.split_depth = 4
settings.split_least = 0.1
