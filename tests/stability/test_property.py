"""Random small scenes: finite, not negative, no crash, no hang, flux never grows."""

from __future__ import annotations

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from photon_map.core import Settings
from photon_map.core.photon_pass import Batch, trace_batch
from photon_map.core.prepared import prepare
from photon_map.tests.stability.random_scenes import small_scene
from photon_map.tests.stability.support import film_of

#: The same examples in every run.
QUIET = settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
    database=None,
)


@QUIET
@given(small_scene(), st.integers(0, 1000))
def test_any_scene_gives_a_finite_picture(small, seed):
    film_of(
        small.scene, passes=2, seed=seed, photons_global=512, photons_caustic=512, threads=1
    )


@QUIET
@given(small_scene(plain=True), st.booleans())
def test_the_flux_of_a_photon_never_grows(small, caustic):
    options = Settings(photon_depth=16)
    prepared = prepare(small.scene, options)
    walk = trace_batch(prepared, options, 0, Batch(caustic, 0, 256, 256))
    flux = walk.photons["flux"].astype(np.float64)
    assert np.isfinite(flux).all() and (flux >= 0).all()
    for name in ("position", "direction", "normal"):
        assert np.isfinite(walk.photons[name]).all()
    order = np.argsort(walk.order)
    path, most = walk.order[order] // options.photon_depth, flux[order].max(axis=1)
    same = path[1:] == path[:-1]
    assert (most[1:][same] <= most[:-1][same] * (1 + 1e-5)).all()
