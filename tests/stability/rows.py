"""The hard cases one by one, and the tests that hold each of them.

``make accuracy`` prints them with what the tests have measured; ``test_rows.py`` sees that
no test is left out and none is missing.
"""

from __future__ import annotations

from typing import NamedTuple


class Row(NamedTuple):
    """A hard case, what it is held to, and its tests (without ``test_``)."""

    case: str
    law: str
    tests: tuple[str, ...]


ROWS = (
    Row("coordinate scale 1e-4 to 1e4, all estimators", "the picture at scale 1",
        ("scale_changes_no_picture",)),
    Row("coordinate offset 1e5, all estimators", "the picture at the origin",
        ("offset_changes_no_picture",)),
    Row("index exactly 1, 1 +- 1e-6, 0.2 and 4", "(1 - F) / (1 + F); 1; n^2",
        ("sun_through_a_slab", "a_ball_in_a_white_furnace_vanishes",
         "inside_a_medium_radiance_is_n_squared", "a_body_of_index_1_changes_no_light")),
    Row("total reflection at the critical angle +- 1e-6 rad", "n^2 (1 - F) or 0; all flux",
        ("critical_angle_seen_from_inside_glass",
         "photons_at_the_critical_angle_keep_their_flux")),
    Row("grazing incidence to 1e-6 rad: sun, view, photons", "S sin; F; S A sin",
        ("a_grazing_sun_lights_a_floor_by_its_sine", "a_view_that_grazes_glass",
         "a_beam_that_grazes_a_mirror_keeps_its_flux",
         "a_narrow_beam_that_grazes_a_mirror_keeps_its_flux")),
    Row("light radius 1 to 1e-6 and 0: direct", "I cos / r^2, whatever the radius",
        ("direct_light_of_a_sphere_of_any_radius", "direct_light_of_a_spot_of_any_radius")),
    Row("light radius 1 to 1e-6 and 0: by a mirror, through glass",
        "virtual lamp; integral of Fresnel's share over the sphere",
        ("caustic_of_a_sphere_of_any_radius", "caustic_of_a_spot_of_any_radius",
         "a_lamp_behind_a_pane")),
    Row("light radius 0.9 to 1e-6 and 0: indirect", "a^2 I / (pi (1 - a))",
        ("indirect_light_of_a_sphere_of_any_radius",)),
    Row("a light touching a surface", "I cos / r^2; reference path tracer",
        ("a_sphere_that_touches_the_floor", "a_sphere_half_sunk_into_the_floor",
         "a_point_lamp_on_the_floor_is_finite")),
    Row("a light inside glass", "as if bare",
        ("a_lamp_inside_a_glass_ball_shines_as_if_bare",)),
    Row("a light behind glass", "integral of Fresnel's share", ("a_lamp_behind_a_pane",)),
    Row("camera inside glass, on a face and in its plane", "n^2; 1 or n^2",
        ("inside_a_medium_radiance_is_n_squared",
         "a_camera_on_a_face_of_glass_sees_one_side_or_the_other",
         "a_camera_at_a_face_of_glass_sees_the_furnace")),
    Row("coincident and nearly coincident faces",
        "one face; slab on a table by Fresnel",
        ("a_floor_twice_is_a_floor", "faces_back_to_back_are_one",
         "glass_on_a_table_whatever_the_gap")),
    Row("slivers", "two large faces", ("a_floor_of_slivers_is_a_floor",)),
    Row("zero area, NaN and infinite vertices, dropped and counted", "without them",
        ("degenerate_faces_are_dropped_and_counted", "only_dropped_faces",
         "faces_that_only_float32_makes_degenerate_harm_nothing")),
    Row("open and flipped meshes", "furnace; as unflipped; powers of n^2",
        ("a_flipped_body_loses_no_light",
         "a_flipped_floor_is_a_floor",
         "an_open_shell_keeps_light_between_its_index_squared")),
    Row("walls 1e-5 thick", "0, no leak",
        ("no_light_leaks_through_thin_walls", "no_light_leaks_out_of_thin_walls")),
    Row("64 bounces in a gem, 64 total reflections in a bar", "furnace; flux; (1 - F)^2",
        ("a_gem_in_a_white_furnace", "a_gem_lets_out_all_photons",
         "64_total_reflections_of_a_view_lose_nothing",
         "64_total_reflections_of_photons_lose_nothing")),
    Row("mirror box: bounded time, right energy", "4 pi I = E (1 - a) A; 1 / (1 - r)",
        ("a_mirror_box_gives_the_floor_all_its_light", "a_glowing_mirror_box_sums_its_series",
         "a_box_of_mirrors_alone_ends_in_bounded_time")),
    Row("albedo 1", "n E; 1", ("albedo_1_stays_finite_and_bounded",
        "white_paint_in_a_white_furnace_is_white", "albedos_at_the_ends")),
    Row("light ratios to 1e6:1", "a^2 I / (pi (1 - a)) beside the bright one",
        ("a_dim_lamp_keeps_its_share_beside_a_bright_one",)),
    Row("1e9 W and 1e-9 W", "proportional", ("watts_scale_every_layer",)),
    Row("one photon, none", "virtual lamp over 4000 passes",
        ("few_photons", "one_photon_a_pass_is_right_in_the_mean")),
    Row("one pixel", "finite", ("one_pixel",)),
    Row("one face, none, all in one plane", "what glows; the world",
        ("one_face", "no_face_at_all", "all_in_one_plane_and_the_camera_in_it")),
    Row("2000 lights", "sum of I cos / r^2", ("two_thousand_lamps_add_up",)),
    Row("caustic of a 1 cm lens in a 1 km scene", "the lens alone",
        ("caustic_of_a_lens_of_1_cm_in_a_scene_of_1_km",)),
    Row("random scenes", "finite, not negative; flux of a photon never grows",
        ("any_scene_gives_a_finite_picture", "the_flux_of_a_photon_never_grows")),
)  # fmt: skip
