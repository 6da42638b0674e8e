"""The photon pass: from the lights to the photon maps, and asking them."""
