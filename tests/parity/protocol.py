"""How often a scene of the suite is rendered, and how a worker tells that it is alive."""

#: Seeds of one round; rounds are added until the image's mean is known well enough.
SEEDS = 8
ROUNDS = 4
#: Standard error of the image's mean, as a share of it, that is well enough.
ENOUGH = 0.001
#: File in the worker's folder, touched at every image and every kernel compiled: a machine that
#: is busy may take minutes for the kernels, one that hangs touches nothing.
PULSE = "pulse"
