//! The problems of `references/`, embedded.

macro_rules! deck {
    ($name:literal) => {
        ($name, include_str!(concat!("../../references/", $name, "/deck.inp")))
    };
}

/// Every problem of `references/`: its name and its deck.
///
/// ```
/// use pintle_scene::Scene;
/// use pintle_solve::{Options, REFERENCES, solve};
///
/// let (name, deck) = REFERENCES.iter().find(|(name, _)| *name == "drawer").ok_or("no drawer")?;
/// let scene = Scene::parse(name, deck)?;
/// let solution = solve::<f64>(&scene, &Options::default()).map_err(|ended| ended.why)?;
/// assert_eq!(solution.events.len(), 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub static REFERENCES: &[(&str, &str)] = &[
    deck!("andrews"),
    deck!("belt_swing"),
    deck!("block"),
    deck!("bricard"),
    deck!("cardan_shaft"),
    deck!("carrier_jumps"),
    deck!("chain"),
    deck!("clutch"),
    deck!("collar_held"),
    deck!("collision"),
    deck!("cross_friction"),
    deck!("cross_swing"),
    deck!("cv_joint"),
    deck!("cylinder_eccentric"),
    deck!("cylinder_wander"),
    deck!("damped_coast"),
    deck!("damper_oneway"),
    deck!("double_hinge"),
    deck!("double_pendulum"),
    deck!("drawer"),
    deck!("driven_plane"),
    deck!("ellipse_slide"),
    deck!("failure"),
    deck!("failure_hang"),
    deck!("flyball"),
    deck!("four_bar"),
    deck!("free_top"),
    deck!("friction_decay"),
    deck!("helical_slide"),
    deck!("hinge_rest"),
    deck!("incline_rest"),
    deck!("incline_return"),
    deck!("ladder"),
    deck!("limit_cycle"),
    deck!("load_reversal"),
    deck!("lock"),
    deck!("lock_flywheel"),
    deck!("lock_slide"),
    deck!("oscillator"),
    deck!("pendulum"),
    deck!("pendulum_cart"),
    deck!("pendulum_turns"),
    deck!("planar_edge"),
    deck!("planar_spin"),
    deck!("press"),
    deck!("projectile"),
    deck!("puck"),
    deck!("retractor_drum"),
    deck!("rotating_arm"),
    deck!("rough_four_bar"),
    deck!("scotch_yoke"),
    deck!("self_locking"),
    deck!("slider_crank"),
    deck!("slot"),
    deck!("spherical_pendulum"),
    deck!("spin_down"),
    deck!("stacked"),
    deck!("static_axial"),
    deck!("static_belt"),
    deck!("static_drawer"),
    deck!("static_hinge"),
    deck!("static_lever"),
    deck!("static_rings"),
    deck!("static_slot"),
    deck!("stop_between"),
    deck!("stop_elastic"),
    deck!("stop_friction"),
    deck!("stop_pendulum"),
    deck!("stop_rigid"),
    deck!("stop_together"),
    deck!("stribeck"),
    deck!("top"),
    deck!("translator_moment"),
    deck!("turntable"),
    deck!("two_blocks"),
    deck!("two_masses"),
    deck!("unbalance"),
    deck!("wander"),
];
