//! Frictions as decks define them.

use pintle_kinematics::catalog::ConnectionType;
use pintle_model::behavior::Conditions;
use pintle_model::behavior::friction::{
    Branch, Coefficient, Context, Flag, Frictions, Input, State, Status, StickStiffness, of_behavior,
};
use pintle_scene::{Code, Diagnostic, Scene};

fn built(name: &str, behavior: &str, is_planar: bool) -> Result<Frictions, Diagnostic> {
    let deck = format!("*NODE\n1, 0., 0., 0.\n*CONNECTOR BEHAVIOR, NAME=B\n{behavior}");
    let scene = Scene::parse("deck.inp", &deck)
        .unwrap_or_else(|error| panic!("{deck}\n{}", error.render(110, false)));
    of_behavior(&scene.behaviors["B"], &ConnectionType::named(name, None).unwrap(), is_planar, 2.0)
}

fn input(displacement: [f64; 6], forces: [f64; 6]) -> Input<'static, f64> {
    Input { displacement, forces, duration: None, context: Context::default() }
}

/// The friction of the slider in the slider-crank deck.
#[test]
fn predefined_friction_of_a_translator() {
    let frictions =
        built("TRANSLATOR", "*CONNECTOR FRICTION, PREDEFINED\n0.05, 0.1, 10.\n*FRICTION\n0.1\n", false)
            .unwrap();
    let [friction] = frictions.frictions.as_slice() else { panic!("{frictions:?}") };
    assert_eq!(friction.coefficient, Coefficient::Constant(0.1));
    assert_eq!(friction.stick_stiffness, StickStiffness::ElasticSlip(2e-4));
    let outcome = friction.update(
        &State::default(),
        &input([0.1, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 3.0, 4.0, 0.5, 0.3, 0.4]),
        Branch::Decided,
    );
    assert_eq!((outcome.status, outcome.contact, outcome.normal), (Status::Slip, 25.0, 35.0));
    assert!((outcome.force[0] - 3.5).abs() < 1e-15);
}

/// The derived component of the guide's example, torque, radial and bending, is the predefined contact force.
#[test]
fn a_derived_component_equals_the_predefined_contact_force() {
    let user = "*CONNECTOR DERIVED COMPONENT, NAME=N\n2, 3\n1., 1.\n*CONNECTOR DERIVED COMPONENT, NAME=N\n5, 6\n20., 20.\n*CONNECTOR DERIVED COMPONENT, NAME=N\n4\n20.\n*CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=N, STICK STIFFNESS=1.E4\n, 10.\n*FRICTION\n0.1\n";
    let user = built("TRANSLATOR", user, false).unwrap();
    let predefined = built(
        "TRANSLATOR",
        "*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=1.E4\n0.05, 0.1, 10.\n*FRICTION\n0.1\n",
        false,
    )
    .unwrap();
    let forces = [0.0, 3.0, -4.0, 0.5, -0.3, 0.4];
    let [a, b] = [&user, &predefined].map(|f| {
        f.frictions[0].tangent(
            &State::default(),
            &input([0.1, 0.0, 0.0, 0.0, 0.0, 0.0], forces),
            Branch::Decided,
        )
    });
    assert_eq!((a.0.normal, a.0.force), (b.0.normal, b.0.force));
    for k in 0..6 {
        assert!((a.1.force[0].forces[k] - b.1.force[0].forces[k]).abs() < 1e-15);
    }
}

/// Slip in a plane by a potential, with everything that a deck can say.
#[test]
fn a_potential_is_read_as_given() {
    let deck = "*CONNECTOR FRICTION, CONTACT FORCE=1, STICK STIFFNESS=500.\n0.25, 2.\n*CONNECTOR POTENTIAL, EXPONENT=2.\n2, 1.\n3, 0.5\n4, 0.25\n*FRICTION, EXPONENTIAL DECAY, TAUMAX=7.\n0.5, 0.2, 3.\n";
    let frictions = built("PLANAR", deck, false).unwrap();
    let [friction] = frictions.frictions.as_slice() else { panic!() };
    assert_eq!((friction.radius, friction.maximum), (0.25, Some(7.0)));
    assert_eq!(friction.coefficient, Coefficient::Exponential { at_rest: 0.5, kinetic: 0.2, decay: 3.0 });
    let (point, _) = friction.criterion.at(&[-3.0, 1.2, 0.8, 0.5, 0.0, 0.0], 0.5, None, &Context::default());
    assert!((point.tangential - (1.44_f64 + 2.56 + 4.0).sqrt()).abs() < 1e-15);
    assert_eq!((point.contact, point.normal), (-3.0, 1.0));
    let outcome = friction.update(
        &State::default(),
        &input([0.0, 1.0, 0.5, 2.0, 0.0, 0.0], [98.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Branch::Decided,
    );
    assert_eq!((outcome.limit, outcome.status), (7.0, Status::Slip));
}

/// Hysteretic friction of prescribed strength: an internal contact force alone, here over the accumulated slip.
#[test]
fn internal_forces_need_no_contact() {
    let deck =
        "*CONNECTOR FRICTION, COMPONENT=1, STICK STIFFNESS=1000.\n, 10., 0.\n, 20., 0.5\n*FRICTION\n0.1\n";
    let friction = built("AXIAL", deck, false).unwrap().frictions.remove(0);
    let first = friction.update(
        &State::default(),
        &input([0.251, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 6]),
        Branch::Decided,
    );
    // 1000 (0.251 − Δγ) = 0.1 (10 + 20 Δγ): Δγ = 250/1002.
    assert!((first.slip_increment - 250.0 / 1002.0).abs() < 1e-16, "{first:?}");
    let second =
        friction.update(&first.state(), &input([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 6]), Branch::Decided);
    assert_eq!((second.normal, second.force[0]), (20.0, 2.0));
    assert!((second.accumulated_slip - (1.251 - 0.002)).abs() < 1e-15);
}

#[test]
fn test_data_and_tables_give_coefficients() {
    let of = |data: &str| {
        let deck = format!("*CONNECTOR FRICTION, PREDEFINED\n{data}");
        built("SLOT", &deck, false).map(|f| f.frictions[0].coefficient.clone())
    };
    let Coefficient::Exponential { at_rest, kinetic, decay } =
        of("*FRICTION, EXPONENTIAL DECAY, TEST DATA\n0.3\n0.21, 2.\n0.2\n").unwrap()
    else {
        panic!()
    };
    assert_eq!((at_rest, kinetic), (0.3, 0.2));
    assert!((kinetic + (at_rest - kinetic) * (-decay * 2.0).exp() - 0.21).abs() < 1e-15);
    let Coefficient::Exponential { kinetic, decay, .. } =
        of("*FRICTION, EXPONENTIAL DECAY, TEST DATA\n0.3\n0.21, 2.\n").unwrap()
    else {
        panic!()
    };
    assert!(
        ((0.21 - kinetic) / (0.3 - kinetic) - 0.05).abs() < 1e-13
            && (decay - 20_f64.ln() / 2.0).abs() < 1e-14
    );
    assert_eq!(
        of("*FRICTION, EXPONENTIAL DECAY, TEST DATA\n0.3\n0.21\n").unwrap_err().code(),
        Code::MissingData
    );
    assert_eq!(
        of("*FRICTION, EXPONENTIAL DECAY, TEST DATA\n0.3\n0.1, 2.\n0.2\n").unwrap_err().code(),
        Code::NumberOutOfRange
    );
    assert!(matches!(of("*FRICTION\n0.3, 0.\n0.2, 1.\n").unwrap(), Coefficient::Table(_)));
    let deck = "*CONNECTOR FRICTION, PREDEFINED\n*FRICTION\n0.3, , , 20.\n0.2, , , 100.\n";
    let friction = built("SLOT", deck, false).unwrap().frictions.remove(0);
    let forces = [0.0, 10.0, 0.0, 0.0, 0.0, 0.0];
    let warm = Conditions { temperature: Some(60.0), fields: vec![] };
    let mut increment = input([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], forces);
    let unknown = friction.update(&State::default(), &increment, Branch::Decided);
    assert!(unknown.flags.iter().any(|flag| matches!(flag, Flag::NotGiven { .. })));
    increment.context.conditions = &warm;
    assert_eq!(friction.update(&State::default(), &increment, Branch::Decided).coefficient, 0.25);
}

#[test]
fn each_component_slides_in_one_friction() {
    let one = "*CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=2\n*FRICTION\n0.1\n";
    let four = one.replace("COMPONENT=1", "COMPONENT=4");
    assert_eq!(built("CYLINDRICAL", &format!("{one}{four}"), false).unwrap().frictions.len(), 2);
    let error = built("CYLINDRICAL", &format!("{one}{one}"), false).unwrap_err();
    assert_eq!((error.code(), error.line()), (Code::RepeatedSuboption, Some(7)));
    let error =
        built("CYLINDRICAL", &format!("*CONNECTOR FRICTION, PREDEFINED\n0.1\n*FRICTION\n0.1\n{four}"), false)
            .unwrap_err();
    assert_eq!((error.code(), error.line()), (Code::RepeatedSuboption, Some(8)));
    assert_eq!(
        built("PLANAR", "*CONNECTOR FRICTION, PREDEFINED\n0.5\n*FRICTION\n0.1\n", false)
            .unwrap()
            .frictions
            .len(),
        2
    );
    let belt = built("SLIPRING", "*CONNECTOR FRICTION, PREDEFINED\n*FRICTION\n0.2\n", false).unwrap();
    assert!(belt.frictions.is_empty() && belt.belt.is_some());
    // In two dimensions a slot presses by f2 alone.
    let slot = built("SLOT", "*CONNECTOR FRICTION, PREDEFINED\n*FRICTION\n0.1\n", true).unwrap();
    let (point, _) =
        slot.frictions[0].criterion.at(&[1.0, -3.0, 4.0, 0.0, 0.0, 0.0], 0.1, None, &Context::default());
    assert_eq!(point.contact, 3.0);
}

#[test]
fn faults_are_told() {
    let law = "*FRICTION\n0.1\n";
    for (name, behavior, code) in [
        ("HINGE", "*CONNECTOR FRICTION, PREDEFINED\n", Code::FrictionParameters),
        ("HINGE", "*CONNECTOR FRICTION, PREDEFINED\n0.1, 0., 0., 0., 1.\n", Code::FrictionParameters),
        ("HINGE", "*CONNECTOR FRICTION, PREDEFINED\n-0.1\n", Code::FrictionParameters),
        ("BEAM", "*CONNECTOR FRICTION, PREDEFINED\n", Code::FrictionNotPredefined),
        ("SLIPRING", "*CONNECTOR FRICTION, PREDEFINED\n1.\n", Code::FrictionParameters),
        ("SLOT", "*CONNECTOR FRICTION, COMPONENT=2, CONTACT FORCE=1\n", Code::ActionNotAvailable),
        (
            "SLOT",
            "*CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=2, STICK STIFFNESS=0.\n",
            Code::NumberOutOfRange,
        ),
        ("SLOT", "*CONNECTOR FRICTION, COMPONENT=1\n1., 2.\n", Code::BadValue),
        ("PLANAR", "*CONNECTOR FRICTION, CONTACT FORCE=1\n*CONNECTOR POTENTIAL\n2\n4\n", Code::MissingData),
        (
            "PLANAR",
            "*CONNECTOR FRICTION, CONTACT FORCE=1\n*CONNECTOR POTENTIAL\n2, 1., 2., NONE\n",
            Code::NumberOutOfRange,
        ),
        (
            "PLANAR",
            "*CONNECTOR FRICTION, CONTACT FORCE=1\n*CONNECTOR POTENTIAL\n1\n",
            Code::ActionNotAvailable,
        ),
    ] {
        let error = built(name, &format!("{behavior}{law}"), false).unwrap_err();
        assert_eq!(error.code(), code, "{name}: {behavior}\n{}", error.render(110, false));
    }
}

/// ELASTIC SLIP is a length, SLIP TOLERANCE a part of one: K_s = L/s_el.
#[test]
fn elastic_slip_is_read() {
    for (options, slip) in [
        ("", 2e-4),
        (", SLIP TOLERANCE=0.01", 0.02),
        (", ELASTIC SLIP=0.002", 0.002),
        (", SLIP TOLERANCE=0.01, ELASTIC SLIP=0.002", 0.002),
    ] {
        let text = format!("*CONNECTOR FRICTION, PREDEFINED\n0.\n*FRICTION{options}\n0.5\n");
        let frictions = built("SLOT", &text, false).unwrap().frictions;
        assert_eq!(frictions[0].stick_stiffness, StickStiffness::ElasticSlip(slip), "{options}");
    }
    let error =
        built("SLOT", "*CONNECTOR FRICTION, PREDEFINED\n0.\n*FRICTION, ELASTIC SLIP=-1.\n0.5\n", false);
    assert!(error.unwrap_err().message().contains("ELASTIC SLIP=-1 is not positive"));
}

/// A potential of forces and moments needs one effective radius, in every row; one of either kind alone takes none.
#[test]
fn effective_radii_are_where_forces_meet_moments() {
    let of = |terms: &str, rows: &str| {
        let deck = format!(
            "*CONNECTOR FRICTION, STICK STIFFNESS=3.\n{rows}\n*CONNECTOR POTENTIAL\n{terms}\n*FRICTION\n0.1\n"
        );
        built_between("CARTESIAN", "CARDAN", &deck).map(|all| all.frictions[0].radius)
    };
    let code = |terms: &str, rows: &str| {
        of(terms, rows).err().map(|error| (error.code(), error.message().to_string()))
    };
    for mixed in ["1\n4", "3\n5", "1\n2\n6"] {
        assert_eq!(of(mixed, "0.5, 1.").ok(), Some(0.5), "{mixed}");
        assert_eq!(code(mixed, ", 1.").unwrap().0, Code::MissingData, "{mixed}");
    }
    for alone in ["1\n2\n3", "4\n5\n6", "4\n6"] {
        assert_eq!(of(alone, ", 1.").ok(), Some(1.0), "{alone}");
        assert_eq!(code(alone, "0.5, 1.").unwrap().0, Code::BadValue, "{alone}");
    }
    assert_eq!(of("1\n4", "0.5, 1., 0.\n0.5, 2., 1.").ok(), Some(0.5));
    let two = code("1\n4", "0.5, 1., 0.\n0.75, 2., 1.").unwrap();
    assert_eq!(two, (Code::BadValue, "the effective radius is 0.5 in one row and 0.75 in another".into()));
    for radius in ["0.", "-1."] {
        let error = code("1\n4", &format!("{radius}, 1.")).unwrap();
        assert_eq!(error.0, Code::NumberOutOfRange, "{radius}");
    }
    // A derived component may enter a potential where the type has its components.
    let derived = |name: &str, component: u8| {
        let deck = format!(
            "*CONNECTOR DERIVED COMPONENT, NAME=D\n{component}\n1.\n*CONNECTOR FRICTION, STICK STIFFNESS=3.\n, 1.\n\
             *CONNECTOR POTENTIAL\nD\n*FRICTION\n0.1\n"
        );
        built(name, &deck, false).is_ok()
    };
    assert!(derived("CARTESIAN", 3) && derived("SLOT", 1) && !derived("SLOT", 2) && !derived("REVOLUTE", 1));
}

fn built_between(first: &str, second: &str, behavior: &str) -> Result<Frictions, Diagnostic> {
    let deck = format!("*NODE\n1, 0., 0., 0.\n*CONNECTOR BEHAVIOR, NAME=B\n{behavior}");
    let scene = Scene::parse("deck.inp", &deck)
        .unwrap_or_else(|error| panic!("{deck}\n{}", error.render(110, false)));
    let connection = ConnectionType::named(first, Some(second)).unwrap();
    of_behavior(&scene.behaviors["B"], &connection, false, 2.0)
}

/// The elastic slip is 1e-4 of the characteristic length, or 1e-4 rad where the slip is an angle; outputs are named by component.
#[test]
fn slips_of_angles_are_angles() {
    for (component, slip, output) in
        [(1, 2e-4, "CSF1"), (3, 2e-4, "CSF3"), (4, 1e-4, "CSM1"), (6, 1e-4, "CSM3")]
    {
        let deck = format!("*CONNECTOR FRICTION, COMPONENT={component}\n, 1.\n*FRICTION\n0.1\n");
        let friction = built_between("CARTESIAN", "CARDAN", &deck).unwrap().frictions.remove(0);
        assert_eq!(friction.stick_stiffness, StickStiffness::ElasticSlip(slip), "{component}");
        assert_eq!(friction.criterion.output, output);
    }
    for (terms, slip) in [("4\n5", 1e-4), ("1\n2", 2e-4)] {
        let deck = format!("*CONNECTOR FRICTION\n, 1.\n*CONNECTOR POTENTIAL\n{terms}\n*FRICTION\n0.1\n");
        let friction = built_between("CARTESIAN", "CARDAN", &deck).unwrap().frictions.remove(0);
        assert_eq!(
            (friction.stick_stiffness, friction.criterion.output),
            (StickStiffness::ElasticSlip(slip), "CSFC")
        );
    }
    let hinge =
        built("HINGE", "*CONNECTOR FRICTION, PREDEFINED\n0.05, 0.1, 10.\n*FRICTION\n0.1\n", false).unwrap();
    assert_eq!(hinge.frictions[0].stick_stiffness, StickStiffness::ElasticSlip(1e-4));
}

/// The internal contact force over a position, with and without a temperature; what is left empty is 0 beside another contact
/// force, and missing without.
#[test]
fn internal_contact_forces_over_positions() {
    let of = |options: &str, rows: &str| {
        let deck = format!(
            "*CONNECTOR FRICTION, COMPONENT=1, STICK STIFFNESS=3.{options}\n{rows}\n*FRICTION\n0.1\n"
        );
        built_between("CARTESIAN", "CARDAN", &deck)
    };
    let conditions = Conditions { temperature: Some(20.0), ..Conditions::default() };
    let normal = |options: &str, rows: &str, force: f64| {
        let friction = of(options, rows).unwrap().frictions.remove(0);
        let mut at = input([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, force, 0.0, 0.0, 0.0, 0.0]);
        at.context = Context {
            position: [0.0, 0.0, 0.5, 0.0, 0.0, 0.0],
            conditions: &conditions,
            ..Context::default()
        };
        friction.update(&State::default(), &at, Branch::Decided).normal
    };
    let position = ", INDEPENDENT COMPONENTS=POSITION";
    assert_eq!(normal(position, "3\n, 1., 0.\n, 2., 1.", 0.0), 1.5);
    assert_eq!(normal(position, "3\n, 1., 0., , 20.\n, 2., 1., , 20.", 0.0), 1.5);
    assert_eq!(
        normal(position, "3\n, 1., 0., , 10.\n, 2., 1., , 10.\n, 3., 0., , 30.\n, 4., 1., , 30.", 0.0),
        2.5
    );
    let pressed = format!("{position}, CONTACT FORCE=2");
    assert_eq!(normal(&pressed, "3\n, , 0.\n, 2., 1.", 4.0), 5.0);
    assert_eq!(of(position, "3\n, , 0.\n, 2., 1.").unwrap_err().code(), Code::MissingData);
}

/// Every flag has its own name.
#[test]
fn flags_have_names() {
    for (flag, name) in [
        (Flag::NoTraction, "no-traction"),
        (Flag::TiedMaximum { terms: [1, 2] }, "tied-maximum"),
        (Flag::ReturnedAlongTraction, "returned-along-traction"),
        (Flag::Unstable, "unstable"),
        (Flag::Slack, "slack"),
    ] {
        assert_eq!(flag.name(), name);
    }
}
