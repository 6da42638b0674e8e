"""How often a scene of the suite is rendered."""

#: Seeds of one round; rounds are added until the image's mean is known well enough.
SEEDS = 8
ROUNDS = 4
#: Standard error of the image's mean, as a share of it, that is well enough.
ENOUGH = 0.001
