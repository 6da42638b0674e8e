import bpy

settings = bpy.context.scene.photon_map

settings.passes = 1024
settings.seconds = 0.0
settings.error_goal = 0.02
settings.adaptive = True
settings.photons_automatic = False
settings.photons_caustic = 500000
settings.photons_global = 50000
settings.caustic_radius = 1.0
settings.alpha = 2 / 3
settings.light_samples = 1
settings.gather_rays = 2
settings.camera_depth = 64
settings.photon_depth = 64
settings.min_throughput = 0.0001
settings.split_depth = 4
settings.split_least = 0.1
