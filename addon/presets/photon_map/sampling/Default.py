import bpy

settings = bpy.context.scene.photon_map

settings.passes = 64
settings.seconds = 0.0
settings.error_goal = 0.0
settings.adaptive = True
settings.photons_automatic = True
settings.photons_caustic = 100000
settings.photons_global = 100000
settings.caustic_radius = 1.4
settings.alpha = 2 / 3
settings.light_samples = 1
settings.gather_rays = 4
settings.camera_depth = 32
settings.photon_depth = 32
settings.min_throughput = 0.0001
settings.split_depth = 4
settings.split_least = 0.1
