//! States that stand exactly on a singular point, where doubles can: what draws come near to and never meet.

use crate::case::{Case, Step};
use crate::sampling::definition;
use crate::singular::beside::{Site, Way, beside, sites};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::State;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::Pair;
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{Matrix, add, apply, product, sub};

pintle_kinematics::named! {
    /// How a state stands on a point.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum Stand {
        /// As models have it: one axis turns, the nodes lie along one, and nothing moves but one degree of freedom.
        Structured = "along axes",
        /// Nodes in one place, initially and now.
        Coincident = "coincident nodes",
        /// Nodes that were apart initially, and have moved to one place.
        Met = "nodes that have met",
        /// As `Structured`, all of it turned as one by any rotation: what was equal is still equal, and no more orthogonal than rounding leaves it.
        Turned = "along axes, turned",
        /// Everything moves, and what the point leaves free is random.
        Random = "any",
    }
}

impl Stand {
    /// Whether such a state stands on a point.
    fn is_of(self, site: &Site) -> bool {
        match (self, site.way()) {
            // Without a length there is no strain.
            (Self::Coincident | Self::Met, Some(Way::Material)) => false,
            // Nodes without a distance coincide in any case.
            (Self::Coincident, Some(Way::Distance)) => false,
            _ => true,
        }
    }
}

/// A state on every singular point of a type, removable ones among them, in every way to stand there.
pub fn cases_on(connection: &ConnectionType) -> Vec<Case> {
    let mut known: Vec<&'static str> = Vec::new();
    let mut found = Vec::new();
    for (_, site) in sites(connection) {
        // Components share points.
        if known.contains(&site.at) {
            continue;
        }
        known.push(site.at);
        for stand in Stand::ALL.into_iter().filter(|stand| stand.is_of(&site)) {
            found.extend(case_on(connection, &site, stand));
        }
    }
    found
}

fn case_on(connection: &ConnectionType, site: &Site, stand: Stand) -> Option<Case> {
    let name = format!("{} on {}, {}", connection.name, site.at, stand.name());
    let draw = &mut Draw::new(&name);
    if stand != Stand::Random {
        draw.structured();
    }
    let mut case = beside(connection, site, 0.0, 0.0, draw)?;
    let initial = case.definition.initial;
    let meets = Pair { reference: [0.0; 3], ..initial };
    match stand {
        Stand::Coincident => {
            case.definition = definition(connection, meets, 1.0);
            case.path.iter_mut().for_each(|step| step.state.pair.reference = [0.0; 3]);
        }
        Stand::Met => {
            let apart = if initial.reference == [0.0; 3] { draw.direction() } else { initial.reference };
            case.definition = definition(connection, Pair { reference: apart, ..initial }, 1.0);
            for step in &mut case.path {
                let pair = &mut step.state.pair;
                pair.reference = apart;
                pair.b.displacement = sub(pair.a.displacement, apart);
            }
        }
        Stand::Structured | Stand::Turned | Stand::Random => {}
    }
    let turned = (stand == Stand::Turned).then(|| exp(Draw::new(&name).rotation(0.3, 1.2)));
    let mut before = case.definition.initial;
    let last = case.path.len().saturating_sub(1);
    for (i, step) in case.path.iter_mut().enumerate() {
        let State { pair: mut after, velocity, acceleration } = step.state;
        for node in [&mut after.a, &mut after.b] {
            node.triad = at_right_angles(node.triad);
        }
        if let Some(rotation) = turned.filter(|_| i == last) {
            let apart = apply(&rotation, after.separation());
            for node in [&mut after.a, &mut after.b] {
                node.triad = product(&rotation, &node.triad);
            }
            after.b.displacement = add(after.a.displacement, sub(apart, after.reference));
        }
        *step = Step::between(&before, after);
        (step.state.velocity, step.state.acceleration) = (velocity, acceleration);
        before = after;
    }
    Some(Case { name, ..case })
}

/// What is a right angle but for rounding, as one.
fn at_right_angles(triad: Matrix<f64>) -> Matrix<f64> {
    const ROUNDED: f64 = 1e-14;
    let is_right = triad.as_flattened().iter().all(|x| (x - x.round()).abs() < ROUNDED);
    if is_right { triad.map(|row| row.map(f64::round)) } else { triad }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::audit_case;
    use crate::oracles::oracle::Narrow;
    use crate::sampling::types;
    use crate::settings::Settings;
    use pintle_kinematics::catalog::TABLE;
    use pintle_kinematics::measure::LOCK;
    use rayon::prelude::*;

    /// They stand on their points: the connector itself has no distance to a declared set but of rounding.
    #[test]
    fn states_stand_on_singular_points() {
        let mut stood = 0;
        for connection in types() {
            for (k, site) in sites(&connection) {
                for stand in Stand::ALL.into_iter().filter(|stand| stand.is_of(&site)) {
                    let case = case_on(&connection, &site, stand).unwrap();
                    let narrow = Narrow::of(&case).unwrap();
                    let of_component = narrow.margins()[k].filter(|margin| margin.set == site.set);
                    if let Some(margin) = of_component {
                        assert!(margin.distance < LOCK, "{}: {margin:?}", case.name);
                        stood += 1;
                    }
                }
            }
        }
        assert!(stood > 100, "{stood}");
    }

    /// Nothing is called wrong there: on each point of each measure, by the first type that has it.
    #[test]
    fn nothing_is_wrong_on_singular_points() {
        let mut known = Vec::new();
        let mut cases = Vec::new();
        for connection in TABLE {
            let new =
                sites(connection).into_iter().filter(|(_, site)| !known.contains(&(site.way(), site.at)));
            let new: Vec<Site> = new.map(|(_, site)| site).collect();
            for site in new {
                known.push((site.way(), site.at));
                let stands = Stand::ALL.into_iter().filter(|stand| stand.is_of(&site));
                cases.extend(stands.map(|stand| case_on(connection, &site, stand).unwrap()));
            }
        }
        let settings = Settings::default();
        cases.par_iter().for_each(|case| {
            for check in audit_case(case, &settings, false, 1) {
                assert!(!check.verdict.is_mismatch(), "{}: {check:?}", case.name);
            }
        });
        assert!(cases.len() > 30, "{}", cases.len());
    }
}
