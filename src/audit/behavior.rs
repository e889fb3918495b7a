//! BehaviorSlopes of elastic and viscous forces of a scene's connector, against differences of the forces on 237-bit numbers.

use crate::case::Case;
use crate::case::failing::{Failing, SlopesCase};
use crate::case::quantity::Quantity;
use crate::judge::bound::C;
use crate::judge::outcome::{Against, Check};
use crate::judge::table::{Entry, ResultTable};
use crate::mutants::mutant::{Mistake, Mutant};
use crate::oracles::differences::FIRST_STEP;
use crate::oracles::oracle::Oracle;
use crate::settings::Settings;
use crate::singular::sides::Sides;
use pintle_kinematics::catalog::{COMPONENT, FORCE};
use pintle_kinematics::connector::{Output, Request};
use pintle_kinematics::scalar::{Real, U, Wide};
use pintle_model::behavior::state::Behavior;
use pintle_model::behavior::{Conditions, Motion, Unknown};

/// Why slopes are undecided.
const LACKS: &str = "a force depends on a temperature or field that is not given (--temperature, --fields; Settings::conditions)";

/// Mistakes in slopes: a secant, elastic for viscous, the matrix transposed, derivatives per degree, components exchanged. `rows` are
/// the components (from 0) that have one; `secants` gives their places in a row, and what stands there.
fn mistakes(
    table: &ResultTable,
    rows: &[usize],
    secants: &dyn Fn(usize) -> [(usize, f64); 2],
) -> Vec<Mutant> {
    let width = table.width();
    let row_of = |component: usize| rows.iter().position(|known| *known == component);
    let mut found = Vec::new();
    let mut add = |mistake, changes: Vec<(usize, usize, f64)>| {
        if !changes.is_empty() {
            found.push(Mutant::many(mistake, changes));
        }
    };
    for (row, component) in rows.iter().enumerate() {
        let all = |f: &dyn Fn(usize) -> f64| (0..width).map(|j| (row, j, f(j))).collect();
        for (column, secant) in secants(*component) {
            if secant.is_finite() && table.want(row, column) != 0.0 {
                add(Mistake::SecantForTangent, vec![(row, column, secant)]);
            }
        }
        add(Mistake::ElasticForViscous, all(&|j| table.want(row, (j + 6) % width)));
        let is_angle = |j: usize| j % 6 >= 3;
        let per_degree =
            |j: usize| if is_angle(j) { table.want(row, j).to_radians() } else { table.want(row, j) };
        add(Mistake::DegreesForRadians, all(&per_degree));
        for other in (0..row).filter(|other| rows[*other] / 3 == component / 3) {
            let mut changes: Vec<(usize, usize, f64)> = all(&|j| table.want(other, j));
            changes.extend((0..width).map(|j| (other, j, table.want(row, j))));
            add(Mistake::RowsSwapped, changes);
        }
    }
    let transposed = rows.iter().enumerate().flat_map(|(row, component)| {
        (0..width).filter_map(move |j| Some((row, j, table.want(row_of(j % 6)?, 6 * (j / 6) + component))))
    });
    add(Mistake::BlockTransposed, transposed.collect());
    found
}

/// The slopes at the end of a case, beside what they must be.
#[derive(Clone, Debug)]
pub struct BehaviorSlopes {
    /// Those of forces that are known.
    pub table: ResultTable,
    /// Whether a force depends on what is not given.
    pub lacks: bool,
}

/// Judges the slopes at the end of a case; `None` where there are none. Undecided where a force depends on what is not given.
pub(super) fn audit_behavior(
    case: &Case,
    behavior: &Behavior,
    settings: &Settings,
    proves: bool,
) -> Option<Check> {
    if !settings.oracles.contains(&Oracle::WideDifferences) {
        return None;
    }
    SlopesCase::of(case, behavior, &settings.conditions)?.audit(settings, proves)
}

/// The slopes at the end of a case; `None` where nothing acts. On a kink of a table there are two slopes.
pub fn slopes(case: &Case, behavior: &Behavior, conditions: &Conditions) -> Option<BehaviorSlopes> {
    SlopesCase::of(case, behavior, conditions)?.slopes()
}

impl SlopesCase {
    /// Whether forces have slopes: springs or dampers that are not all rigid.
    pub(super) fn acts(behavior: &Behavior) -> bool {
        let rigid = behavior.elasticity.rigid();
        let springs =
            behavior.elasticity.components().into_iter().zip(rigid).any(|(acts, rigid)| acts && !rigid);
        springs || behavior.damping.components().contains(&true)
    }

    /// The end of a case; `None` where nothing acts.
    fn of(case: &Case, behavior: &Behavior, conditions: &Conditions) -> Option<Self> {
        let acts = [behavior.elasticity.components(), behavior.damping.components()];
        if !acts.as_flattened().contains(&true) {
            return None;
        }
        let asked = Request::new(&[Output::CP, Output::CCU, Output::CV], [true; 6], 0);
        let (evaluation, _) = case.evaluation(&asked)?;
        let value = |of: [Option<f64>; 6]| of.map(Option::unwrap_or_default);
        Some(Self {
            name: case.name.clone(),
            elasticity: behavior.elasticity.clone(),
            damping: behavior.damping.clone(),
            motion: Motion {
                position: value(evaluation.position),
                constitutive: value(evaluation.constitutive),
                velocity: value(evaluation.velocity),
            },
            conditions: conditions.clone(),
            length: case.length,
        })
    }

    /// The check at this motion.
    pub(super) fn audit(&self, settings: &Settings, proves: bool) -> Option<Check> {
        let BehaviorSlopes { mut table, lacks } = self.slopes()?;
        if let Some(planted) = settings.planted {
            planted.spoil_table(&mut table);
        }
        let mut check = Check::new(Some(Quantity::BehaviorTangent), Against::Oracle(Oracle::WideDifferences));
        if !table.entries.is_empty() {
            check = table.check(proves, &self.name, None);
            check.fails_at(|| Failing::Slopes(Box::new(self.clone())));
        }
        if lacks {
            check.add_undecided(LACKS, &self.name);
        }
        (!check.states.is_empty()).then_some(check)
    }

    /// The slopes, and what they must be.
    pub(super) fn tables(&self) -> Vec<ResultTable> {
        self.slopes().map(|slopes| slopes.table).into_iter().collect()
    }

    fn slopes(&self) -> Option<BehaviorSlopes> {
        let Self { motion, conditions, .. } = self;
        let mut behavior = Behavior::default();
        (behavior.elasticity, behavior.damping) = (self.elasticity.clone(), self.damping.clone());
        // On a row of a table there are two slopes, and next to it rounding decides which.
        let on_kink = behavior.kinks(motion, conditions).next().is_some();
        // Without temperature and fields some forces are not known: their slopes are not judged, and that is said.
        let laws =
            [behavior.elasticity.forces(motion, conditions), behavior.damping.forces(motion, conditions)];
        let is_known = |i: usize| laws.iter().all(|law| law.unknown[i].is_none());
        let lacks = |law: &pintle_model::behavior::Forces<f64>| {
            law.unknown.iter().flatten().any(|why| *why != Unknown::Rigid)
        };
        let tangent = behavior.tangent(motion, conditions, None, [false; 6]);
        let size = |k: usize, x: f64| x.abs().max(if k < 3 { self.length } else { 1.0 });
        let forces = |of_velocity: bool, j: usize, h: Wide| -> [Wide; 6] {
            let wide = |x: [f64; 6]| x.map(Wide::from_f64);
            let mut moved = Motion {
                position: wide(motion.position),
                constitutive: wide(motion.constitutive),
                velocity: wide(motion.velocity),
            };
            if of_velocity {
                moved.velocity[j] += h;
            } else {
                moved.position[j] += h;
                moved.constitutive[j] += h;
            }
            behavior.forces(&moved, conditions)
        };
        let still = forces(false, 0, Wide::from_f64(0.0));
        let mut table = ResultTable::new(Quantity::BehaviorTangent);
        let motions = [false, true].into_iter().flat_map(|of_velocity| (0..6).map(move |j| (of_velocity, j)));
        let motions: Vec<(bool, usize)> = motions.collect();
        table.columns = motions
            .iter()
            .map(|(of_velocity, j)| format!("{}({})", if *of_velocity { "v" } else { "u" }, COMPONENT[*j]))
            .collect();
        let scales = behavior.slope_scales(motion, conditions);
        let of = |(of_velocity, j): (bool, usize)| {
            let size = size(j, if of_velocity { motion.velocity[j] } else { motion.constitutive[j] });
            let both = |h: Wide| [forces(of_velocity, j, -h), forces(of_velocity, j, h)];
            let h = Wide::from_f64(FIRST_STEP * size);
            let [minus, plus] = both(h);
            let slope = [0, 1, 2, 3, 4, 5].map(|i| (plus[i] - minus[i]) / (h + h));
            if !on_kink {
                return (size, slope, [None; 6]);
            }
            let steps = [h / Wide::integer(2), h, Wide::from_f64(Sides::COARSE * size)];
            let moved = steps.map(both);
            let sides = |i: usize| {
                let moved = moved.each_ref().map(|both| both.each_ref().map(|forces| Some(forces[i])));
                let scale = scales[usize::from(of_velocity)][i][j];
                Sides::along(still[i], &moved, &steps, scale).filter(|sides| sides.differ(C * U * scale))
            };
            (size, slope, [0, 1, 2, 3, 4, 5].map(sides))
        };
        let wanted: Vec<(f64, [Wide; 6], [Option<Sides>; 6])> =
            motions.iter().map(|motion| of(*motion)).collect();
        for i in (0..6).filter(|i| is_known(*i)) {
            table.rows.push(format!("∂{}", FORCE[i]));
            for (column, ((of_velocity, j), (size, want, sides))) in motions.iter().zip(&wanted).enumerate() {
                let slopes = if *of_velocity { &tangent.velocity } else { &tangent.displacement };
                let name = format!("∂{}/∂{}", FORCE[i], table.columns[column]);
                let scale = still[i].to_f64().abs() / size
                    + want[i].to_f64().abs()
                    + scales[usize::from(*of_velocity)][i][*j];
                let entry = Entry::new(name, slopes[i][*j], want[i], scale, (i / 3, column / 3, 0));
                table.entries.push(Entry { sides: sides[i], ..entry });
            }
        }
        let rows: Vec<usize> = (0..6).filter(|i| is_known(*i)).collect();
        let secants = |i: usize| {
            let (elastic, viscous) =
                (laws[0].value[i].unwrap_or(f64::NAN), laws[1].value[i].unwrap_or(f64::NAN));
            [(i, elastic / motion.constitutive[i]), (6 + i, viscous / motion.velocity[i])]
        };
        table.mistakes = mistakes(&table, &rows, &secants);
        Some(BehaviorSlopes { table, lacks: laws.iter().any(lacks) })
    }
}
