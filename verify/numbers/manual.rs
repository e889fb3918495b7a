//! The manual's summary tables, transcribed a second time: typed from the pages, not from `src/catalog`. One row for each type,
//! with its page; a row without a type, or a type without a row, fails.
//!
//! Sources. `seed`: the page itself was read in full. `summary`: its summary table was read. `guide`: the page was read in part,
//! and the entry is what its text says. Where a page could not be read the row says `unread`, and holds what follows from the
//! type's definition: those entries test that the catalogue is consistent, not that it is right.

use pintle_kinematics::catalog::{
    Availability, COMPONENT, Class, Condition, ConnectionType, Evidence, Friction, Orientation, SPATIAL,
    Slot, TABLE,
};

/// One page's summary table.
struct Row {
    name: &'static str,
    /// Basic, assembled, or complex; for a basic type also which half of a connector it is.
    class: &'static str,
    constraints: &'static str,
    constraint_forces: &'static str,
    available: &'static str,
    kinetic_forces: &'static str,
    orientation: [&'static str; 2],
    stops: &'static str,
    references: &'static str,
    friction_parameters: &'static str,
    /// Tangential traction; contact force; the output of the friction force.
    friction: &'static [[&'static str; 3]],
    planar: &'static str,
    solvers: &'static str,
    page: &'static str,
}

/// A row in which everything that can be none is none.
const BASIC: Row = Row {
    name: "",
    class: "basic translational",
    constraints: "none",
    constraint_forces: "none",
    available: "none",
    kinetic_forces: "none",
    orientation: ["required", "optional"],
    stops: "none",
    references: "none",
    friction_parameters: "none",
    friction: &[],
    planar: "no",
    solvers: "both",
    page: "",
};
const ROTATIONAL: Row = Row { class: "basic rotational", ..BASIC };
const ASSEMBLED: Row = Row { class: "assembled", ..BASIC };

const MANUAL: &[Row] = &[
    Row {
        name: "ACCELEROMETER",
        orientation: ["optional?", "optional?"],
        solvers: "Explicit only",
        page: "connectiontypedesc-accelerometer, guide; connectiontypecomponents",
        ..BASIC
    },
    Row {
        name: "ALIGN",
        constraints: "ur1 = 0, ur2 = 0, ur3 = 0",
        constraint_forces: "m1, m2, m3",
        orientation: ["optional", "optional"],
        planar: "yes",
        page: "connectiontypedesc-align, summary",
        ..ROTATIONAL
    },
    Row {
        name: "AXIAL",
        available: "u1",
        kinetic_forces: "f1",
        orientation: ["optional", "optional"],
        stops: "l1min ≤ l ≤ l1max",
        references: "l1ref",
        planar: "yes",
        page: "connectiontypedesc-axial, summary",
        ..BASIC
    },
    Row {
        name: "BEAM",
        constraints: "JOIN + ALIGN",
        constraint_forces: "f1, f2, f3, m1, m2, m3",
        orientation: ["optional", "optional"],
        planar: "yes",
        page: "connectiontypedesc-beam (Analysis Guide 31.1.5), summary",
        ..ASSEMBLED
    },
    Row {
        name: "BUSHING",
        constraints: "PROJECTION CARTESIAN + PROJECTION FLEXION-TORSION",
        available: "u1, u2, u3, ur1, ur2, ur3",
        kinetic_forces: "f1, f2, f3, m1, m2, m3",
        stops: "l1min ≤ x ≤ l1max, l2min ≤ y ≤ l2max, l3min ≤ z ≤ l3max, θ1min ≤ α1 ≤ θ1max, θ2min ≤ α2 ≤ θ2max, \
                θ3min ≤ β ≤ θ3max",
        references: "l1ref, l2ref, l3ref, θ1ref, θ2ref, θ3ref",
        page: "connectiontypedesc-bushing, summary",
        ..ASSEMBLED
    },
    Row {
        name: "CARDAN",
        available: "ur1, ur2, ur3",
        kinetic_forces: "m1, m2, m3",
        orientation: ["required?", "optional?"],
        stops: "θ1min ≤ α ≤ θ1max, θ2min ≤ β ≤ θ2max, θ3min ≤ γ ≤ θ3max",
        references: "θ1ref, θ2ref, θ3ref",
        page: "connectiontypedesc-cardan, guide",
        ..ROTATIONAL
    },
    Row {
        name: "CARTESIAN",
        available: "u1, u2, u3",
        kinetic_forces: "f1, f2, f3",
        orientation: ["optional", "ignored"],
        stops: "l1min ≤ x ≤ l1max, l2min ≤ y ≤ l2max, l3min ≤ z ≤ l3max",
        references: "l1ref, l2ref, l3ref",
        planar: "yes",
        page: "connectiontypedesc-cartesian, summary",
        ..BASIC
    },
    Row {
        name: "CONSTANT VELOCITY",
        constraints: "β = β0",
        constraint_forces: "m2",
        page: "connectiontypedesc-constantvelocity, guide",
        ..ROTATIONAL
    },
    Row {
        name: "CVJOINT",
        constraints: "JOIN + CONSTANT VELOCITY",
        constraint_forces: "f1, f2, f3, m2",
        page: "connectiontypedesc-cvjoint, summary",
        ..ASSEMBLED
    },
    Row {
        name: "CYLINDRICAL",
        constraints: "SLOT + REVOLUTE",
        constraint_forces: "f2, f3, m2, m3",
        available: "u1, ur1",
        kinetic_forces: "f1, m1",
        stops: "l1min ≤ l ≤ l1max, θ1min ≤ α ≤ θ1max",
        references: "l1ref, θ1ref",
        friction_parameters: "required: R; optional: L, F_C^int",
        friction: &[["√(f1² + (m1/R)²)", "√(f2² + f3²) + (2/L) √(m2² + m3²)", "CSFC"]],
        page: "connectiontypedesc-cylindrical; Analysis Guide 31.1.5, summary",
        ..ASSEMBLED
    },
    Row {
        name: "EULER",
        available: "ur1, ur2, ur3",
        kinetic_forces: "m1, m2, m3",
        orientation: ["required?", "optional?"],
        stops: "θ1min ≤ α ≤ θ1max, θ2min ≤ β ≤ θ2max, θ3min ≤ γ ≤ θ3max",
        references: "θ1ref, θ2ref, θ3ref",
        page: "connectiontypedesc-euler, guide",
        ..ROTATIONAL
    },
    Row {
        name: "FLEXION-TORSION",
        available: "ur1, ur2, ur3",
        kinetic_forces: "m1, m2, m3",
        orientation: ["required?", "optional?"],
        stops: "θ1min ≤ α ≤ θ1max, θ2min ≤ β ≤ θ2max, θ3min ≤ θ ≤ θ3max",
        references: "θ1ref, θ2ref, θ3ref",
        page: "connectiontypedesc-flexiontorsion, guide; the summary unread",
        ..ROTATIONAL
    },
    Row {
        name: "FLOW-CONVERTER",
        class: "specialised rotational",
        constraints: "ur3 = 0",
        constraint_forces: "m3",
        orientation: ["required", "ignored"],
        planar: "Standard only",
        page: "connectiontypedesc-flowconverter, guide; orientations and m3 from connection type RETRACTOR",
        ..ROTATIONAL
    },
    Row {
        name: "HINGE",
        constraints: "JOIN + REVOLUTE",
        constraint_forces: "f1, f2, f3, m2, m3",
        available: "ur1",
        kinetic_forces: "m1",
        stops: "θ1min ≤ α ≤ θ1max",
        references: "θ1ref",
        friction_parameters: "required: R_p; optional: R_a, L_s, M_C^int",
        friction: &[["|m1|", "R_a |f1| + R_p √(f2² + f3²) + (2 R_p/L_s) √(m2² + m3²)", "CSM1"]],
        page: "connectiontypedesc-hinge, guide; friction unread",
        ..ASSEMBLED
    },
    Row {
        name: "JOIN",
        constraints: "x = x0, y = y0, z = z0",
        constraint_forces: "f1, f2, f3",
        orientation: ["optional", "ignored"],
        planar: "yes",
        page: "connectiontypedesc-join, summary",
        ..BASIC
    },
    Row {
        name: "LINK",
        constraints: "l = l0",
        constraint_forces: "f1",
        orientation: ["ignored?", "ignored?"],
        planar: "yes",
        page: "connectiontypecomponents, one line; the rest unread",
        ..BASIC
    },
    Row {
        name: "PLANAR",
        constraints: "SLIDE-PLANE + REVOLUTE",
        constraint_forces: "f1, m2, m3",
        available: "u2, u3, ur1",
        kinetic_forces: "f2, f3, m1",
        stops: "l2min ≤ y ≤ l2max, l3min ≤ z ≤ l3max, θ1min ≤ α ≤ θ1max",
        references: "l2ref, l3ref, θ1ref",
        friction_parameters: "optional: R, F_C^int, M_C^int",
        friction: &[
            ["√(f2² + f3²)", "|f1| + √(m2² + m3²)/R", "CSFC"],
            // κ = 1, contact at the rim (decision D-11); without R nothing turns against the spin.
            ["|m1|", "κ R (|f1| + √(m2² + m3²)/R)", "CSM1"],
        ],
        page: "connectiontypedesc-planar, guide; the second contact moment unread",
        ..ASSEMBLED
    },
    Row {
        name: "PROJECTION CARTESIAN",
        available: "u1, u2, u3",
        kinetic_forces: "f1, f2, f3",
        orientation: ["required?", "optional?"],
        stops: "l1min ≤ x ≤ l1max, l2min ≤ y ≤ l2max, l3min ≤ z ≤ l3max",
        references: "l1ref, l2ref, l3ref",
        planar: "yes",
        page: "connectiontypedesc-projectioncartesian, guide",
        ..BASIC
    },
    Row {
        name: "PROJECTION FLEXION-TORSION",
        available: "ur1, ur2, ur3",
        kinetic_forces: "m1, m2, m3",
        stops: "θ1min ≤ α1 ≤ θ1max, θ2min ≤ α2 ≤ θ2max, θ3min ≤ β ≤ θ3max",
        references: "θ1ref, θ2ref, θ3ref",
        page: "connectiontypedesc-projectionflexiontorsion, guide; the summary unread",
        ..ROTATIONAL
    },
    Row {
        name: "RADIAL-THRUST",
        available: "u1, u3",
        kinetic_forces: "f1, f3",
        orientation: ["required", "ignored?"],
        stops: "l1min ≤ r ≤ l1max, l3min ≤ l ≤ l3max",
        references: "l1ref, l3ref",
        page: "connectiontypedesc-radialthrust, summary",
        ..BASIC
    },
    Row {
        name: "RETRACTOR",
        constraints: "JOIN + FLOW-CONVERTER",
        constraint_forces: "f1, f2, f3, m3",
        orientation: ["required", "ignored"],
        planar: "Standard only",
        page: "connection type RETRACTOR, Figure 31.1.5–24 and Summary",
        ..ASSEMBLED
    },
    Row {
        name: "REVOLUTE",
        constraints: "e1a·e2b = 0, e1a·e3b = 0",
        constraint_forces: "m2, m3",
        available: "ur1",
        kinetic_forces: "m1",
        stops: "θ1min ≤ α ≤ θ1max",
        references: "θ1ref",
        page: "connection type REVOLUTE, Figure 31.1.5–25 and Summary",
        ..ROTATIONAL
    },
    Row {
        name: "ROTATION",
        available: "ur1, ur2, ur3",
        kinetic_forces: "m1, m2, m3",
        orientation: ["optional", "optional"],
        stops: "θ1min ≤ φ1 ≤ θ1max, θ2min ≤ φ2 ≤ θ2max, θ3min ≤ φ3 ≤ θ3max",
        references: "θ1ref, θ2ref, θ3ref",
        planar: "yes",
        page: "connection type ROTATION, Figure 31.1.5–26 and Summary",
        ..ROTATIONAL
    },
    Row {
        name: "ROTATION-ACCELEROMETER",
        orientation: ["optional", "optional"],
        solvers: "Explicit only",
        page: "connection type ROTATION-ACCELEROMETER, Figure 31.1.5–27 and Summary",
        ..ROTATIONAL
    },
    Row {
        name: "SLIDE-PLANE",
        constraints: "x = x0",
        constraint_forces: "f1",
        available: "u2, u3",
        kinetic_forces: "f2, f3",
        orientation: ["required", "ignored"],
        stops: "l2min ≤ y ≤ l2max, l3min ≤ z ≤ l3max",
        references: "l2ref, l3ref",
        friction_parameters: "optional: F_C^int",
        friction: &[["√(f2² + f3²)", "|f1|", "CSFC"]],
        page: "connection type SLIDE-PLANE, Figure 31.1.5–28; Analysis Guide 31.1.5, summary",
        ..BASIC
    },
    Row {
        name: "SLIPRING",
        class: "complex",
        available: "u1, u2",
        kinetic_forces: "f1, f2",
        orientation: ["ignored?", "ignored?"],
        references: "ε1ref",
        friction: &[["|T2 − T1|", "min(T1, T2)", "CSF2"]],
        planar: "Standard only",
        page: "connectiontypedesc-slipring, guide; stops and the summary unread",
        ..BASIC
    },
    Row {
        name: "SLOT",
        constraints: "y = y0, z = z0",
        constraint_forces: "f2, f3",
        available: "u1",
        kinetic_forces: "f1",
        orientation: ["required", "ignored"],
        stops: "l1min ≤ l ≤ l1max",
        references: "l1ref",
        friction_parameters: "optional: F_C^int",
        friction: &[["|f1|", "√(f2² + f3²)", "CSF1"]],
        planar: "yes",
        page: "connectiontypedesc-slot, summary; connfrictionbehav",
        ..BASIC
    },
    Row {
        name: "TRANSLATOR",
        constraints: "SLOT + ALIGN",
        constraint_forces: "f2, f3, m1, m2, m3",
        available: "u1",
        kinetic_forces: "f1",
        stops: "l1min ≤ l ≤ l1max",
        references: "l1ref",
        friction_parameters: "optional: R_r, L, F_C^int",
        friction: &[["|f1|", "|m1|/R_r + √(f2² + f3²) + (2/L) √(m2² + m3²)", "CSF1"]],
        planar: "yes",
        page: "connection type TRANSLATOR, Friction and Summary",
        ..ASSEMBLED
    },
    Row {
        name: "UJOINT",
        constraints: "JOIN + UNIVERSAL",
        constraint_forces: "f1, f2, f3, m2",
        available: "ur1, ur3",
        kinetic_forces: "m1, m3",
        // The table prints γ twice; the first is α (decision D-12).
        stops: "θ1min ≤ α ≤ θ1max, θ3min ≤ γ ≤ θ3max",
        references: "θ1ref, θ3ref",
        friction_parameters: "required: R_p, L_a; optional: R_a, L_s, M_C1^int, M_C3^int",
        friction: &[
            ["|m1|", "R_a |f·e1a| + R_p |f − (f·e1a) e1a| + (2 R_p/L_a) |m2|", "CSM1"],
            ["|m3|", "R_a |f·e3b| + R_p |f − (f·e3b) e3b| + (2 R_p/L_a) |m2|", "CSM3"],
        ],
        page: "connectiontypedesc-ujoint; Analysis Guide 31.1.5, summary; contact moments unread",
        ..ASSEMBLED
    },
    Row {
        name: "UNIVERSAL",
        constraints: "e1a·e3b = 0",
        constraint_forces: "m2",
        available: "ur1, ur3",
        kinetic_forces: "m1, m3",
        stops: "θ1min ≤ α ≤ θ1max, θ3min ≤ γ ≤ θ3max",
        references: "θ1ref, θ3ref",
        page: "connectiontypedesc-universal, summary",
        ..ROTATIONAL
    },
    Row {
        name: "WELD",
        constraints: "JOIN + ALIGN",
        constraint_forces: "f1, f2, f3, m1, m2, m3",
        orientation: ["optional", "optional"],
        planar: "yes",
        page: "connectiontypeassembledconnections; the summary unread",
        ..ASSEMBLED
    },
];

const fn class(entry: &ConnectionType) -> &'static str {
    match entry.class {
        Class::BasicTranslational => "basic translational",
        Class::BasicRotational => "basic rotational",
        Class::SpecialisedRotational => "specialised rotational",
        Class::Assembled => "assembled",
        Class::Complex => "complex",
    }
}

/// The constraints in the manual's form, sorted: a page may print them in another order than their components have.
fn constraints(entry: &ConnectionType) -> String {
    if let [Some(t), Some(r)] = entry.halves {
        return format!("{} + {}", t.name, r.name);
    }
    let printed = (0..6).filter_map(|k| match entry.slots[k] {
        Slot::Constrained(measure, Condition::Held) => Some(format!("{0} = {0}0", measure.symbol())),
        Slot::Constrained(_, Condition::ZeroOrHeld(function)) => Some(format!("{} = 0", function.formula())),
        Slot::Constrained(_, Condition::Zero(_)) => Some(format!("{} = 0", COMPONENT[k])),
        _ => None,
    });
    sorted(printed.map(|s| s.to_string()).collect())
}

fn sorted(mut items: Vec<String>) -> String {
    items.sort();
    if items.is_empty() { "none".into() } else { items.join(", ") }
}

/// A question mark says that the page's table could not be read: such a rule warns instead of refusing.
fn orientation(entry: &ConnectionType, node: usize) -> String {
    let rule = entry.orientation[node];
    let name = match rule.orientation {
        Orientation::Ignored => "ignored",
        Orientation::Optional => "optional",
        Orientation::Required => "required",
    };
    let doubt = matches!(rule.evidence, Evidence::P | Evidence::R);
    format!("{name}{}", if doubt { "?" } else { "" })
}

fn friction_parameters(friction: Option<&Friction>) -> String {
    let symbols = |required: bool| {
        let all = friction.map_or(&[][..], |friction| friction.parameters);
        let wanted = all.iter().filter(|p| p.required == required);
        wanted.map(|p| p.symbol).collect::<Vec<_>>().join(", ")
    };
    match (symbols(true).as_str(), symbols(false).as_str()) {
        ("", "") => "none".into(),
        ("", optional) => format!("optional: {optional}"),
        (required, "") => format!("required: {required}"),
        (required, optional) => format!("required: {required}; optional: {optional}"),
    }
}

const fn available(availability: Availability, always: &'static str) -> &'static str {
    match availability {
        Availability::Always => always,
        Availability::ExplicitOnly => "Explicit only",
        Availability::StandardOnly => "Standard only",
        Availability::Never => "no",
    }
}

/// The page of each type.
pub(crate) fn pages() -> impl Iterator<Item = (&'static str, &'static str)> {
    MANUAL.iter().map(|row| (row.name, row.page))
}

/// Types whose pages permit an orientation that gives their nodes no rotations.
const WITHOUT_ROTATIONS: [&str; 2] = ["AXIAL", "JOIN"];

/// The nodes that each type gives rotations: where its page permits an orientation.
pub(crate) fn rotating() -> impl Iterator<Item = (&'static str, [bool; 2])> {
    MANUAL.iter().map(|row| {
        let is_given = !WITHOUT_ROTATIONS.contains(&row.name);
        (row.name, row.orientation.map(|rule| is_given && !rule.starts_with("ignored")))
    })
}

/// Multi-point constraints, as their pages have them: the type, its number of nodes, its equations without material flow, the
/// angles that are degrees of freedom of further nodes, whether it is for Standard only, and the page.
const MPCS: [(&str, usize, usize, usize, bool, &str); 6] = [
    ("BEAM", 2, 6, 0, false, "keyword page mpc; General multi-point constraints"),
    ("LINK", 2, 1, 0, false, "keyword page mpc; General multi-point constraints"),
    ("PIN", 2, 3, 0, false, "keyword page mpc; General multi-point constraints"),
    ("REVOLUTE", 3, 3, 1, true, "keyword page mpc; Theory Guide, revolute MPC"),
    ("TIE", 2, 6, 0, false, "keyword page mpc; General multi-point constraints"),
    ("UNIVERSAL", 4, 3, 2, true, "keyword page mpc; Theory Guide, universal MPC; order of its axes unread"),
];

/// The pages of the multi-point constraints, under the names `MPC BEAM`.
pub(crate) fn mpc_pages() -> impl Iterator<Item = (String, &'static str)> {
    MPCS.iter().map(|row| (format!("MPC {}", row.0), row.5))
}

/// The pages of the relations, by what they are of.
const RELATIONS: [(&str, &str); 5] = [
    (
        "DISTRIBUTING COUPLING",
        "keyword page distributing; Theory Guide, distributing coupling; finite motion unread",
    ),
    ("EQUATION", "keyword page equation; Linear constraint equations"),
    (
        "KINEMATIC COUPLING",
        "keyword page kinematic; Theory Guide, kinematic coupling; axes of universal unread",
    ),
    ("RIGID BODY", "keyword page rigidbody"),
    ("TIE", "keyword page tie; nodes only"),
];

/// The pages of the relations, under their names.
pub(crate) fn relation_pages() -> impl Iterator<Item = (String, &'static str)> {
    RELATIONS.iter().map(|(name, page)| ((*name).to_string(), *page))
}

#[test]
fn the_constraints_are_those_of_the_manual() {
    let here: Vec<_> = pintle_kinematics::mpc::TABLE
        .iter()
        .map(|entry| {
            let equations = entry.kind.rows(false).iter().filter(|row| **row).count();
            (entry.name, entry.nodes.len(), equations, entry.angles.len(), entry.standard_only)
        })
        .collect();
    let there: Vec<_> = MPCS.iter().map(|row| (row.0, row.1, row.2, row.3, row.4)).collect();
    assert_eq!(here, there);
}

/// The catalogue says what the pages say, field by field.
#[test]
fn the_catalogue_is_the_manual() {
    let mut differences = Vec::new();
    for row in MANUAL {
        let Some(entry) = TABLE.iter().find(|entry| entry.name == row.name) else {
            differences.push(format!("{} ({}) is not in the catalogue", row.name, row.page));
            continue;
        };
        let mut compare = |field: &str, catalogue: &str, manual: &str| {
            if catalogue != manual {
                let name = row.name;
                differences
                    .push(format!("{name}, {field}: catalogue {catalogue:?}, {} {manual:?}", row.page));
            }
        };
        compare("class", class(entry), row.class);
        let printed = match row.constraints {
            "none" => "none".to_string(),
            printed => sorted(printed.split(", ").map(String::from).collect()),
        };
        compare("kinematic constraints", &constraints(entry), &printed);
        compare("constraint forces", &entry.force_list(Slot::is_constrained), row.constraint_forces);
        compare("available components", &entry.component_list(Slot::is_available), row.available);
        compare("kinetic forces", &entry.force_list(Slot::is_available), row.kinetic_forces);
        for (i, node) in ["a", "b"].into_iter().enumerate() {
            compare(&format!("orientation at {node}"), &orientation(entry, i), row.orientation[i]);
        }
        compare("stops", &entry.stop_list(), row.stops);
        compare("constitutive references", &entry.reference_list(), row.references);
        let friction = entry.friction.as_ref();
        compare("friction parameters", &friction_parameters(friction), row.friction_parameters);
        let criteria = friction.map_or(&[][..], |friction| friction.criteria);
        compare("friction criteria", &criteria.len().to_string(), &row.friction.len().to_string());
        for (criterion, [tangential, contact, output]) in criteria.iter().zip(row.friction) {
            let of = friction.expect("criteria belong to a friction");
            compare("tangential traction", &criterion.tangential_formula(of, SPATIAL), tangential);
            compare("contact force", &criterion.contact_formula(of, SPATIAL), contact);
            compare("friction output", criterion.output, output);
        }
        compare("two dimensions", available(entry.planar, "yes"), row.planar);
        compare("solvers", available(entry.availability, "both"), row.solvers);
    }
    for entry in TABLE {
        if !MANUAL.iter().any(|row| row.name == entry.name) {
            differences.push(format!("{} has no row in verify/numbers/manual.rs", entry.name));
        }
    }
    assert!(differences.is_empty(), "{} differences\n{}", differences.len(), differences.join("\n"));
}

/// Rows are in alphabetical order, each type once, each with its page.
#[test]
fn the_rows_are_in_order() {
    for pair in MANUAL.windows(2) {
        assert!(pair[0].name < pair[1].name, "{} before {}", pair[0].name, pair[1].name);
    }
    for row in MANUAL {
        assert!(!row.page.is_empty(), "{} names no page", row.name);
    }
}
