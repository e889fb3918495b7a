//! What is prescribed in a step, and which steps prescribe something else than those before?

use crate::facts::Role;
use crate::steps::ends;
use pintle_model::evaluate::{Fixed, Freedom, keeps_zero};
use pintle_scene::{ConditionKind, ConnectorMotion, Diagnostic, Digits, Label, Scene, Target};
use std::collections::{HashMap, HashSet};

/// What is done to components of connectors, by element and component (0-based).
type Motions = HashMap<(Label, usize), Role>;

/// What prescribed motions do in a step: components of connectors that are held or driven, degrees of freedom that are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prescribed {
    /// The degrees of freedom that are held.
    pub held: Fixed,
    /// What of it was held in all steps before, and is zero.
    pub(crate) resting: Fixed,
    /// What is held in every step: of a state whose step is not known.
    pub(crate) always: Fixed,
    /// Whether it is known when the steps end.
    pub(crate) has_times: bool,
    /// The components of connectors that are held or driven.
    pub motions: Motions,
    pub(crate) driven: HashSet<Freedom>,
    /// Where the nodes are.
    pub(crate) places: HashMap<Label, [f64; 3]>,
    /// The largest coordinate of each node that has rounded ones.
    pub(crate) rounded: HashMap<Label, f64>,
    /// How exact the numbers are that the scene gives.
    pub(crate) digits: Digits,
}

/// Whether a coordinate is taken for rounded: it has digits down to the last. Of rounded numbers one in a million ends in so many zeros.
fn is_rounded(coordinate: f64) -> bool {
    const ZEROS: u32 = 20;
    coordinate != 0.0 && coordinate.to_bits().trailing_zeros() < ZEROS
}

/// The largest coordinate of the nodes that have rounded ones.
fn rounded(scene: &Scene) -> HashMap<Label, f64> {
    let largest = |[x, y, z]: [f64; 3]| x.abs().max(y.abs()).max(z.abs());
    let nodes = scene.nodes.iter().map(|(label, node)| (*label, node.coordinates));
    nodes.filter(|(_, x)| x.iter().any(|x| is_rounded(*x))).map(|(label, x)| (label, largest(x))).collect()
}

impl Prescribed {
    /// What is prescribed in a step, counted from 1; 0 is before the first.
    pub(crate) fn of(scene: &Scene, step: usize) -> Result<Self, Diagnostic> {
        let held = Fixed::held_in_step(scene, step)?;
        let resting = Fixed::resting_in_step(scene, step)?;
        let always = Fixed::resting_in_step(scene, scene.steps.len())?;
        let has_times = ends(scene).is_some();
        let driven = Fixed::in_step(scene, step)?.iter().filter(|freedom| !held.contains(*freedom)).collect();
        let mut motions = Motions::new();
        // What earlier steps drove is not where it was initially, and is driven back, as of nodes.
        let mut driven_before: HashSet<(Label, usize)> = HashSet::new();
        let put = |motion: &ConnectorMotion, motions: &mut Motions, before: &HashSet<(Label, usize)>| {
            let is_held = keeps_zero(scene, (motion.kind, motion.magnitude.unwrap_or(0.0)), &motion.applied);
            let labels: &[Label] = match &motion.target.value {
                Target::Label(label) => std::slice::from_ref(label),
                Target::Set(name) => {
                    scene.element_sets.get(name.as_str()).map_or(&[], |set| set.labels.as_slice())
                }
            };
            for label in labels {
                let key = (*label, usize::from(motion.component).saturating_sub(1));
                motions
                    .insert(key, if is_held && !before.contains(&key) { Role::Held } else { Role::Driven });
            }
        };
        for motion in &scene.connector_motions {
            put(motion, &mut motions, &driven_before);
        }
        for step in scene.steps.iter().take(step) {
            let driven = motions.iter().filter(|(_, role)| **role == Role::Driven).map(|(key, _)| *key);
            driven_before.extend(driven);
            if step.removed.contains(&ConditionKind::ConnectorMotion) {
                motions.clear();
            }
            for motion in &step.connector_motions {
                put(motion, &mut motions, &driven_before);
            }
        }
        let places = scene.nodes.iter().map(|(label, node)| (*label, node.coordinates)).collect();
        let (rounded, digits) = (rounded(scene), Digits::of(scene));
        Ok(Self { held, resting, always, has_times, motions, driven, places, rounded, digits })
    }
}

/// The steps whose boundary conditions and connector motions are not those of the step before, counted from 1; the first one always.
pub fn differing(scene: &Scene) -> Result<Vec<(usize, Prescribed)>, Diagnostic> {
    let mut found = vec![(1, Prescribed::of(scene, 1)?)];
    for step in 2..=scene.steps.len() {
        let next = Prescribed::of(scene, step)?;
        if found.last().is_none_or(|(_, last)| *last != next) {
            found.push((step, next));
        }
    }
    Ok(found)
}
