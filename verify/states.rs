//! Where laws are tried: the cases of the audit's sampler, the same for every run.

pub(crate) use pintle_audit::case::{Case, Step, carried, exact_branch, exact_state, moved};
pub(crate) use pintle_audit::sampling::{
    Extent, Motion, about_1, about_3, cases, cube_orientations, definition, extent, pair, types,
};
pub(crate) use pintle_kinematics::draw::Draw;
pub(crate) use pintle_kinematics::node::dof_size;
pub(crate) use pintle_kinematics::so3::exp;

use pintle_audit::sampling::Region;
use pintle_kinematics::catalog::TABLE;
use pintle_kinematics::connector::{Evaluation, Request, Tally};

/// The end of a path that has one.
pub(crate) trait Ends {
    /// The state judged, and the increment that leads to it.
    fn end(&self) -> &Step;

    /// The evaluation there, and how much was computed for it.
    fn evaluate(&self, request: &Request) -> (Evaluation<f64>, Tally);
}

impl Ends for Case {
    fn end(&self) -> &Step {
        self.last().expect("a path has an end")
    }

    fn evaluate(&self, request: &Request) -> (Evaluation<f64>, Tally) {
        self.evaluation(request).expect("a path has an end")
    }
}

/// No region is passed over because nothing regular was drawn there: every type is tried in each of its regions, at four
/// orientations of a cube at least.
#[test]
fn every_region_has_its_case() {
    for connection in TABLE {
        let found = cases(connection, Extent::Full);
        let has =
            |region: Region| found.iter().any(|case| case.name.ends_with(&format!(" {}", region.name())));
        for region in Region::of(connection, Extent::Full) {
            assert!(
                matches!(region, Region::Cube(_)) || has(region),
                "{}: {}",
                connection.name,
                region.name()
            );
        }
        let cubes = (0..24).filter(|i| has(Region::Cube(*i))).count();
        assert!(cubes >= 4, "{}: only {cubes} cube orientations are regular", connection.name);
    }
    for connection in types() {
        assert!(cases(&connection, Extent::Brief).len() == 2, "{}", connection.name);
    }
}
