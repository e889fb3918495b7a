//! What a two-dimensional element asks of its nodes and orientations.
//!
//! The plane is the global 1-2 plane, z = 0. Of an orientation e1 and e2 lie in it and e3 is ±z, the same at a and at b. With e3 = −z
//! the direction e2 is on the other side of e1, and ur3, which is positive about e3a, is minus the rotation of b against a about z.
//!
//! In an axisymmetric model 1 is the radius r, 2 the axis, and degree of freedom 6 the rotation from r to the axis: the same formulas,
//! with r ≥ 0. Forces are those of the whole circumference.

use pintle_kinematics::catalog::in_plane;
use pintle_kinematics::vector::{Matrix, Vector, column};
use pintle_scene::{Code, ConnectorElement, ConnectorSection, Diagnostic, Dimension, Label, Scene, Spanned};

/// Direction cosines of exact rotations about the global 3-axis carry a few roundings.
const ROUNDING: f64 = 1e-12;

const SOURCE: &str = "by the connector element library, CONN2D2";

const INTO_PLANE: &str = "give points a and b of the plane z = 0, so that e3 is the global z";

/// Whether a direction is ±z.
fn is_third([x, y, _]: Vector<f64>) -> bool {
    x.abs() <= ROUNDING && y.abs() <= ROUNDING
}

/// The nodes of a two-dimensional element that lie out of the plane; in an axisymmetric model, those with a negative radius.
pub(super) fn nodes(scene: &Scene, label: Label, element: &ConnectorElement) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    if element.dimension != Dimension::Two {
        return found;
    }
    for node in [element.a, element.b].into_iter().flatten() {
        let Some(place) = scene.nodes.get(&node) else { continue };
        let [r, _, z] = place.coordinates;
        let mut fail = |code, message: String, remedy: &str| {
            found.push(Diagnostic::error(code, place.span, message, SOURCE).help(remedy).in_scene(scene));
        };
        if z != 0.0 {
            let message = format!("element {label} is two-dimensional, and its node {node} has z = {z}");
            fail(Code::OutOfPlane, message, "leave out the third coordinate, or use TYPE=CONN3D2");
        }
        if r < 0.0 && scene.is_axisymmetric() {
            let message = format!("element {label} is axisymmetric, and its node {node} has the radius {r}");
            fail(
                Code::NegativeRadius,
                message,
                "coordinate 1 is the radius: put the model where it is positive",
            );
        }
    }
    found
}

/// Axes of a coupling of a two-dimensional model, by the orientation of this name.
///
/// # Errors
/// Where e3 is not ±z.
pub(super) fn axes(scene: &Scene, name: &Spanned<String>, axes: &[Vector<f64>; 3]) -> Result<(), Diagnostic> {
    if is_third(axes[2]) {
        return Ok(());
    }
    let message = format!(
        "e1 and e2 of orientation {} do not lie in the 1-2 plane of a two-dimensional model",
        name.value
    );
    Err(Diagnostic::error(Code::OutOfPlane, name.span, message, "as for CONN2D2")
        .help(INTO_PLANE)
        .in_scene(scene))
}

/// Terms of equations in degrees of freedom that a two-dimensional model has not.
pub(super) fn terms(scene: &Scene, warnings: &mut Vec<Diagnostic>) {
    if !scene.two_dimensional {
        return;
    }
    let all =
        scene.equations.iter().flat_map(|equation| equation.terms.iter().map(move |term| (equation, term)));
    for (equation, term) in all.filter(|(_, term)| !in_plane(term.degree_of_freedom)) {
        let (node, number) = (term.node, term.degree_of_freedom);
        let message = format!(
            "an equation has degree of freedom {number} of node {node}, and the model is two-dimensional: the term is dropped"
        );
        let remedy = "its nodes have the degrees of freedom 1, 2, 6 and 10";
        warnings.push(
            Diagnostic::warning(Code::OutOfPlane, equation.span, message, SOURCE)
                .help(remedy)
                .in_scene(scene),
        );
    }
}

/// The orientations of a two-dimensional element whose e3 is not ±z; else those whose e3 are opposite.
pub(super) fn orientations(
    scene: &Scene,
    label: Label,
    section: &ConnectorSection,
    triads: &[Option<Matrix<f64>>; 2],
) -> Vec<Diagnostic> {
    let names = [&section.orientation_a, &section.orientation_b];
    let mut found = Vec::new();
    let mut fail = |name: &Spanned<String>, message: String, remedy: &str| {
        found.push(
            Diagnostic::error(Code::OutOfPlane, name.span, message, SOURCE).help(remedy).in_scene(scene),
        );
    };
    let (mut along, mut is_in_plane) = ([None; 2], true);
    for (end, (name, triad)) in names.into_iter().zip(triads).enumerate() {
        let (Some(name), Some(triad)) = (name, triad) else { continue };
        let e3 = column(triad, 2);
        if !is_third(e3) {
            let message = format!(
                "element {label}: e1 and e2 of orientation {} do not lie in the 1-2 plane",
                name.value
            );
            fail(name, message, INTO_PLANE);
            is_in_plane = false;
        }
        along[end] = Some(e3[2]);
    }
    // Without an orientation at a its directions are the global ones.
    if let ([of_a, Some(of_b)], Some(name)) = (along, names[1])
        && is_in_plane
        && of_a.unwrap_or(1.0) * of_b < 0.0
    {
        let message = format!("element {label}: e3 at its nodes is the global z at one and −z at the other");
        fail(name, message, "swap the sides of points a and b in one of the two orientations");
    }
    found
}
