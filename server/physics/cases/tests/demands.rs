//! Every case meets its demands, family by family.

use ballroom_cases::{all, select};

/// Runs the cases of a family and shows the rows that fall short.
fn assert_met(family: &str) {
    let mut short = vec![];
    for case in select(&[family.to_owned()]).unwrap() {
        match case.run() {
            Err(fault) => short.push(format!("{}: the scene is refused: {fault}", case.id)),
            Ok(rows) => short.extend(rows.iter().filter(|row| !row.is_met()).map(|row| {
                let demand = &row.demand;
                format!(
                    "{} ({}): {}, {} over {}: measured {:e}, demanded {:e} {}",
                    case.id,
                    case.title,
                    demand.quantity,
                    demand.norm,
                    demand.span,
                    row.measured,
                    demand.limit,
                    demand.unit
                )
            })),
        }
    }
    assert!(short.is_empty(), "these fall short:\n{}", short.join("\n"));
}

macro_rules! families {
    ($($claim:ident: $family:literal,)*) => {
        const FAMILIES: &[&str] = &[$($family),*];
        $(#[test] fn $claim() { assert_met($family); })*
    };
}

families! {
    balls_fall_along_an_incline_as_g_sin_alpha_says: "B0/",
    beads_swing_in_a_parabola_with_their_elliptic_period: "B1/",
    balls_swing_in_pit_and_cylinder_with_their_period: "B2/",
    beads_turn_on_a_paraboloid_with_their_elliptic_radial_period: "B3/",
    balls_keep_their_horizontal_circle_and_turn_as_it_says: "B4/",
    small_motion_at_bottom_and_top_is_linear: "B5/",
    spin_splits_small_motion_in_two_turns: "B6/",
    spin_and_axial_speed_trade_along_a_cylinder: "B8/",
    routh_s_invariants_hold_on_surfaces_of_revolution: "B9/",
    bounces_against_a_wall_come_when_they_must: "B15/",
    beads_on_a_wall_collapse_below_the_threshold_only: "B17/",
    closed_paths_leave_the_rotation_that_is_known: "Q/",
    every_scheme_shows_its_order: "O/",
    balls_follow_references_of_another_formulation: "R/",
    hits_between_a_wall_and_a_heavy_ball_spell_pi: "H1/",
    as_many_balls_leave_a_cradle_as_came: "H2/",
    balls_that_meet_at_once_part_by_symmetry: "H3/",
    a_break_is_its_own_mirror_image: "H4/",
    a_bullet_hits_every_time: "H5/",
    grazes_are_told_from_misses: "H6/",
    exact_tangency_gives_next_to_no_impulse: "H7/",
    both_walls_of_a_corner_turn_a_ball_at_one_instant: "H8/",
    wedges_unfold: "H9/",
    a_wedged_ball_hits_as_often_as_its_wedge_says: "H10/",
    beads_on_a_wall_hit_as_often_as_their_restitution_says: "H12/",
    bounces_come_at_their_times: "H13/",
    a_floor_as_curved_as_the_ball_is_refused: "H14/",
    a_warped_chart_changes_nothing: "H17/",
    running_along_a_border_is_no_hit: "H18/",
    a_saddle_holds_at_rest_and_grows_by_cosh: "H19/",
    spin_steadies_a_ball_on_a_hill_above_its_threshold: "H20/",
    rest_changes_no_bit: "H21/",
    hits_without_number_keep_the_energy: "H22/",
    motion_turned_round_goes_back: "H23/",
    the_tick_rate_changes_no_bit: "H24/",
    far_from_the_origin_all_is_the_same: "H25/",
    balls_a_thousandfold_apart_in_size_meet_exactly: "H26/",
    balls_that_do_not_fit_are_refused_by_name: "H27/",
    rows_of_balls_hit_in_their_order: "H31/",
    chaos_is_followed_to_its_horizon: "H32/",
    a_force_that_flips_gives_parabolas: "H34/",
    gases_are_what_their_figures_say_and_keep_their_energy: "G/",
    what_else_breaks_engines_is_answered: "X",
}

#[test]
fn every_case_belongs_to_a_family_above() {
    for case in all() {
        assert!(FAMILIES.iter().any(|family| case.id.starts_with(family)), "{} is not run", case.id);
    }
}
