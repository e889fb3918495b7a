//! Component forces given from outside, and what they do to the nodes.

use crate::behavior::Tangent;
use crate::evaluate::model::{ConnectorElement, Model};
use crate::evaluate::mpc::MpcElement;
use crate::evaluate::mpc::forces::{NOT_GIVEN, given_forces as of_mpc};
use pintle_kinematics::catalog::{COMPONENT, FORCE};
use pintle_kinematics::connector::{
    Components, Connector, Evaluation, Flag, Mask, NodalMatrix, NodalRow, Output, Request, State, Tally,
};
use pintle_kinematics::force::{ForceRows, Want};
use pintle_kinematics::measure::SingularClass;
use pintle_scene::{Code, Diagnostic, ElementForces, ForceSign, Label, LabelMap, State as SceneState};
use std::collections::{BTreeMap, HashMap};

/// What the forces of a connector's components give at one state; each part is present where it was asked for.
#[derive(Clone, Debug)]
pub struct ForceResult {
    /// CTF: the forces of the components.
    pub components: Components<f64>,
    /// PM: the moments by which the printed formula gives the same moment.
    pub printed: Components<f64>,
    /// LM: the multipliers of the equations enforced.
    pub multipliers: Components<f64>,
    /// NF: nodal forces of both ends, the ground's reaction among them, in the order of [`pintle_kinematics::node::DOF`].
    pub nodal: Option<NodalRow<f64>>,
    /// KG: the geometric stiffness Σ f_k ∂²c_k.
    pub geometric: Option<NodalMatrix<f64>>,
    /// DNF: ∂NF/∂q at constant component forces.
    pub derivative: Option<NodalMatrix<f64>>,
    /// KT: Jᵀ (∂F/∂u) J + KG, the velocities of components moving along. ∂NF/∂q is KT − KG + DNF.
    pub tangent: Option<NodalMatrix<f64>>,
    /// CT: Jᵀ (∂F/∂v) J, by nodal velocities, where velocities are rates.
    pub damping: Option<NodalMatrix<f64>>,
    /// KR: the columns ∂NF/∂λ by the reactions of components.
    pub by_reactions: Components<NodalRow<f64>>,
    /// The column of KR by the tension of the belt on the other side of the ring, where its friction depends on it.
    pub by_beyond: Option<NodalRow<f64>>,
    /// The column of KR by the angle of wrap at the ring, where that is measured and its friction depends on it; KT holds it still.
    pub by_angle: Option<NodalRow<f64>>,
    /// What needs care about them.
    pub flags: Vec<Flag>,
}

/// Why forces do not belong to a connector.
struct Fault {
    code: Code,
    message: String,
    remedy: String,
}

impl Model {
    /// Whether the forces given to states belong to connectors that have them; `file` is where they were read.
    ///
    /// # Errors
    /// All that do not, each with its state, element, component and a remedy.
    pub fn check_forces(&self, states: &[SceneState], first: u64, file: &str) -> Result<(), Diagnostic> {
        let check = ForceCheck::new(self);
        let of = |(counted, state): (u64, &SceneState)| {
            check.check((&state.forces, &state.mpc_forces), state.number.unwrap_or(counted), file).err()
        };
        Diagnostic::joined((first..).zip(states).filter_map(of)).map_or(Ok(()), Err)
    }
}

/// Whether forces belong to connectors that have them, for one state at a time.
#[derive(Clone, Debug)]
pub struct ForceCheck<'a> {
    elements: LabelMap<&'a ConnectorElement>,
    mpcs: HashMap<String, &'a MpcElement>,
}

impl<'a> ForceCheck<'a> {
    /// For the connectors and multi-point constraints of a model.
    pub fn new(model: &'a Model) -> Self {
        Self {
            elements: model.connectors.iter().map(|element| (element.label, element)).collect(),
            mpcs: model.mpcs.iter().map(|element| (element.label(), element)).collect(),
        }
    }

    /// Whether the forces of the state called `number` are those of connectors and constraints; `file` is where they were read.
    ///
    /// # Errors
    /// All that do not belong, each with its state, element, component and a remedy.
    pub fn check(
        &self,
        (forces, mpc_forces): (&BTreeMap<Label, ElementForces>, &BTreeMap<String, ElementForces>),
        number: u64,
        file: &str,
    ) -> Result<(), Diagnostic> {
        let told = |given: &ElementForces, title: &str, Fault { code, message, remedy }: Fault| {
            let message = format!("state {number}, {title}: {message}");
            Diagnostic::error(code, given.span, message, "here").help(remedy).in_file(file)
        };
        let of_elements = forces.iter().filter_map(|(label, given)| {
            let element = self.elements.get(label)?;
            let fault = component_forces(&element.connector, given).err()?;
            Some(told(given, &element.title(), fault))
        });
        let of_mpcs = mpc_forces.iter().filter_map(|(nodes, given)| {
            let element = self.mpcs.get(nodes)?;
            let (code, message, remedy) = of_mpc(element, given).err()?;
            Some(told(given, &element.title(), Fault { code, message, remedy }))
        });
        Diagnostic::joined(of_elements.chain(of_mpcs)).map_or(Ok(()), Err)
    }
}

/// The internal forces of the components of a connector that its state gives; none where it gives none.
///
/// # Errors
/// The code of the first force that is not of its type: [`ForceCheck`] tells more.
pub(super) fn given_forces(
    connector: &Connector<f64>,
    state: &SceneState,
    element: Label,
) -> Result<Option<Components<f64>>, Code> {
    let given = state.forces.get(&element).map(|given| component_forces(connector, given));
    given.transpose().map_err(|fault| fault.code)
}

/// The internal forces of the components of a connector.
fn component_forces(connector: &Connector<f64>, given: &ElementForces) -> Result<Components<f64>, Fault> {
    let mut forces = [None; 6];
    let total = |k: usize| FORCE[k].replace('f', "CTF").replace('m', "CTM");
    let reaction = |k: usize| total(k).replace("CT", "CR");
    for k in 0..6 {
        let fail = |code, message: String, remedy: String| Err(Fault { code, message, remedy });
        let (of_total, of_reaction) = (given.total[k], given.reaction[k]);
        if !connector.has_force(k) {
            if of_total.or(of_reaction).is_some_and(|force| force != 0.0) {
                let message = format!("it has no force {}", FORCE[k]);
                let list: Vec<&str> = (0..6).filter(|k| connector.has_force(*k)).map(|k| FORCE[k]).collect();
                let has = if list.is_empty() { "none".to_string() } else { list.join(", ") };
                return fail(
                    Code::ForcesAbsentComponent,
                    message,
                    format!("leave it out, or write 0; its forces are: {has}"),
                );
            }
            continue;
        }
        let is_constrained = connector.is_constrained(k);
        let force = match (of_total, of_reaction) {
            // A gap: it is not given, and not zero.
            (None, None) => continue,
            (Some(total_force), Some(other)) if is_constrained && total_force != other => {
                let message = format!(
                    "{} is constrained, and its total force {total_force} differs from its reaction {other}",
                    COMPONENT[k]
                );
                let remedy = format!("give one of {} and {}", total(k), reaction(k));
                return fail(Code::ForcesContradiction, message, remedy);
            }
            (Some(force), _) => force,
            (None, Some(force)) if is_constrained => force,
            (None, Some(_)) => {
                let message = format!(
                    "{} is available, and {} alone is a part of its force",
                    COMPONENT[k],
                    reaction(k)
                );
                let remedy = format!("give the total force as {} or {}", FORCE[k], total(k));
                return fail(Code::ForcesNotATotal, message, remedy);
            }
        };
        let is_on_b = is_constrained && given.sign == ForceSign::ConstraintsOnB;
        forces[k] = Some(if is_on_b { -force } else { force });
    }
    Ok(forces)
}

impl ForceResult {
    /// What a request names of the forces given; `None` where there are none, or nothing of them is asked for.
    pub(super) fn of(
        connector: &Connector<f64>,
        (state, evaluation): (&State<f64>, &Evaluation<f64>),
        given: Option<Components<f64>>,
        tangent: Option<&Tangent<f64>>,
        request: &Request,
        tally: &mut Tally,
    ) -> Option<Self> {
        if !request.wants_of_forces() {
            return None;
        }
        // Slopes may be known where forces are not.
        let components = given.or(tangent.map(|_| [None; 6]))?;
        let mask = |output: Output| [0, 1, 2, 3, 4, 5].map(|k| request.wants(output, k));
        let [nodal, geometric, derivative] = [Output::NF, Output::KG, Output::DNF].map(mask);
        let [stiffness, damping, reactions] = [Output::KT, Output::CT, Output::KR].map(mask);
        let is_wanted = |mask: Mask| mask.contains(&true);
        let prints = connector.connection().printed.is_some() && is_wanted(mask(Output::PM));
        let rotations = |k: usize| k > 2 && prints;
        let constraints = |k: usize| connector.is_constrained(k) && is_wanted(mask(Output::LM));
        let needed = [0, 1, 2, 3, 4, 5]
            .map(|k| nodal[k] || geometric[k] || derivative[k] || rotations(k) || constraints(k));
        let slopes = tangent.filter(|_| [stiffness, damping, reactions].iter().any(|of| is_wanted(*of)));
        let needed = [0, 1, 2, 3, 4, 5]
            .map(|k| needed[k] || (slopes.is_some() && (stiffness[k] || damping[k] || reactions[k])));
        let want = Want {
            stiffness: is_wanted(geometric) || is_wanted(derivative) || is_wanted(stiffness),
            multipliers: (0..6).any(constraints),
            motions: slopes.filter(|_| is_wanted(stiffness) || is_wanted(damping)).map_or([false; 6], moving),
        };
        let rows =
            connector.force_rows_after(state, &evaluation.branch, needed, want, Some(evaluation), tally);
        let of = |mask: Mask| [0, 1, 2, 3, 4, 5].map(|k| components[k].filter(|_| mask[k]));
        let mut flags = if want.multipliers { dependent(&rows) } else { Vec::new() };
        // A sum without one of its forces would be another one: it is left out, and said to be.
        let mut is_known = |output: Output, mask: Mask| {
            let missing = |k: &usize| mask[*k] && connector.has_force(*k) && components[*k].is_none();
            let why = NOT_GIVEN;
            let before = flags.len();
            let flag = |k: usize| Flag::NotKnown { component: COMPONENT[k], quantity: output.name(), why };
            flags.extend((0..6).filter(missing).map(flag));
            let any = (0..6).any(|k| mask[k] && components[k].is_some());
            is_wanted(mask) && any && flags.len() == before
        };
        let knows_printed = prints && is_known(Output::PM, [0, 1, 2, 3, 4, 5].map(|k| k > 2));
        let rotations = [0, 1, 2, 3, 4, 5].map(|k| k > 2 && connector.is_constrained(k));
        let knows_multipliers =
            want.multipliers && (rotations == [false; 6] || is_known(Output::LM, rotations));
        let knows = [(Output::NF, nodal), (Output::KG, geometric), (Output::DNF, derivative)]
            .map(|(output, mask)| is_wanted(mask) && is_known(output, mask));
        let none = [None; 6];
        let mut result = Self {
            components,
            printed: if knows_printed { rows.printed(&components) } else { none },
            multipliers: if knows_multipliers { rows.multipliers(&components) } else { none },
            nodal: knows[0].then(|| rows.nodal(&of(nodal))),
            geometric: knows[1].then(|| rows.geometric_stiffness(&of(geometric))),
            derivative: knows[2].then(|| rows.derivative(&of(derivative))),
            tangent: None,
            damping: None,
            by_reactions: [None; 6],
            by_beyond: None,
            by_angle: None,
            flags,
        };
        let has_slopes = |k: usize| connector.has_force(k);
        let Some(slopes) = slopes else {
            let why = "the slopes of component forces are not known";
            let missing = [(Output::KT, stiffness), (Output::CT, damping), (Output::KR, reactions)];
            for (output, mask) in missing {
                let lacking = (0..6).filter(|k| mask[*k] && has_slopes(*k));
                result.flags.extend(lacking.map(|k| Flag::NotKnown {
                    component: COMPONENT[k],
                    quantity: output.name(),
                    why,
                }));
            }
            return Some(result);
        };
        // A sum without one of its slopes would be another one.
        let mut knows_slopes = |output: Output, mask: Mask| {
            let unknown = (0..6).filter(|k| mask[*k] && has_slopes(*k));
            let unknown: Vec<_> = unknown.filter_map(|k| Some((k, slopes.unknown[k]?))).collect();
            result.flags.extend(unknown.iter().map(|(k, why)| Flag::NotKnown {
                component: COMPONENT[*k],
                quantity: output.name(),
                why: why.in_words(),
            }));
            is_wanted(mask) && unknown.is_empty()
        };
        let [knows_stiffness, knows_damping, knows_reactions] =
            [(Output::KT, stiffness), (Output::CT, damping), (Output::KR, reactions)]
                .map(|(output, mask)| knows_slopes(output, mask));
        let masked = |matrix: &[[f64; 6]; 6], mask: Mask| {
            let mut kept = *matrix;
            (0..6).filter(|k| !mask[*k]).for_each(|k| kept[k] = [0.0; 6]);
            kept
        };
        // The geometric part needs the forces themselves.
        let mut is_loaded = || {
            let missing = |k: &usize| stiffness[*k] && has_slopes(*k) && components[*k].is_none();
            let why = NOT_GIVEN;
            let missing: Vec<usize> = (0..6).filter(missing).collect();
            result.flags.extend(missing.iter().map(|k| Flag::NotKnown {
                component: COMPONENT[*k],
                quantity: Output::KT.name(),
                why,
            }));
            missing.is_empty()
        };
        let by_rates = slopes.time_step.is_none();
        if knows_stiffness && is_loaded() {
            let mut sum = rows.geometric_stiffness(&of(stiffness));
            add(&mut sum, &rows.material_stiffness(&masked(&slopes.total(), stiffness)));
            if by_rates {
                let velocity = masked(&slopes.velocity, stiffness);
                add(&mut sum, &rows.convective_stiffness(&velocity, &state.velocity));
            }
            result.tangent = Some(sum);
        }
        if knows_damping && by_rates {
            result.damping = Some(rows.material_stiffness(&masked(&slopes.velocity, damping)));
        }
        if knows_reactions {
            let column = |of: &dyn Fn(usize) -> f64| {
                let forces =
                    [0, 1, 2, 3, 4, 5].map(|k| Some(of(k)).filter(|force| reactions[k] && *force != 0.0));
                rows.nodal(&forces)
            };
            for j in (0..6).filter(|j| slopes.reacting[*j]) {
                result.by_reactions[j] = Some(column(&|k| slopes.reaction[k][j]));
            }
            let given = |of: &[f64; 6]| of.iter().any(|slope| *slope != 0.0).then(|| column(&|k| of[k]));
            (result.by_beyond, result.by_angle) = (given(&slopes.beyond), given(&slopes.angle));
        }
        Some(result)
    }
}

/// The components by whose motion forces change.
fn moving(tangent: &Tangent<f64>) -> Mask {
    let by = |j: usize| (0..6).any(|k| tangent.displacement[k][j] != 0.0 || tangent.velocity[k][j] != 0.0);
    [0, 1, 2, 3, 4, 5].map(by)
}

/// Adds one matrix to another.
fn add(sum: &mut NodalMatrix<f64>, other: &NodalMatrix<f64>) {
    for (entry, other) in sum.iter_mut().flatten().zip(other.iter().flatten()) {
        *entry += other;
    }
}

/// Multipliers of equations that are dependent, or nearly so.
fn dependent(rows: &ForceRows<f64>) -> Vec<Flag> {
    const AT: &str = "equations enforced that are dependent";
    let (class, mut flags) = (SingularClass::TrueSingularity, Vec::new());
    for (k, sine) in rows.independence().into_iter().enumerate() {
        let component = COMPONENT[3 + k];
        match sine {
            Some(0.0) => flags.push(Flag::Singular { component, at: AT, class }),
            Some(distance) if distance < pintle_kinematics::connector::ILL_CONDITIONED => {
                flags.push(Flag::IllConditioned { component, at: AT, class, distance });
            }
            _ => {}
        }
    }
    flags
}
