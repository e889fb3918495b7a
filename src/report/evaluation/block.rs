//! One connector or MPC at one state, as every format writes it.

use crate::words;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Branch, Connector, Flag, Output, Request, StopStatus, Turns};
use pintle_kinematics::measure::{Margin, Unit};
use pintle_kinematics::mpc;
use pintle_kinematics::mpc::{DOFS as MPC_DOFS, ROWS as MPC_ROWS};
use pintle_kinematics::node::{DOF, DOF_NUMBER, DOFS};
use pintle_kinematics::scalar::Real;
use pintle_model::behavior::drive::Prescribed;
use pintle_model::behavior::friction;
use pintle_model::behavior::friction::Status;
use pintle_model::behavior::state::Outcome;
use pintle_model::behavior::{Forces, Tangent, Unknown};
use pintle_model::evaluate::{
    ConnectorResult, ForceResult, HingeMoments, Model, MpcElement, MpcForces, MpcResult, MpcSlopes,
    RelationResult,
};
use pintle_scene::Label;

/// A nodal force.
#[derive(Clone, Debug, serde::Serialize)]
pub struct NodalForce {
    /// xa1, θb3, Ψb: the degree of freedom that the force does work on.
    pub name: &'static str,
    /// The node; `None` is the ground, whose reaction this is.
    pub node: Option<Label>,
    /// The node's role.
    pub role: &'static str,
    /// The number of the degree of freedom, 1 to 6 or 10.
    pub dof: u8,
    /// The force, moment or flow force, residual-side, global components.
    pub force: f64,
}

/// Nodal forces and their derivatives by the columns of the block.
#[derive(Clone, Debug, Default)]
pub struct Nodal {
    /// NF.
    pub forces: Vec<NodalForce>,
    /// Derivatives, those that are asked for.
    pub derivatives: Vec<NodalDerivative>,
}

/// Derivatives of the nodal forces.
#[derive(Clone, Debug)]
pub struct NodalDerivative {
    /// KG, DNF, KT, CT, KR.
    pub output: Output,
    /// By what: `None` is the degrees of freedom of the block, else reactions (CRF1 … CRM3) and T2, the tension of the belt on the
    /// other side of a ring.
    pub by: Option<Vec<&'static str>>,
    /// A row for each degree of freedom of the block.
    pub rows: Vec<Vec<f64>>,
}

impl Nodal {
    fn of(connector: &Connector<f64>, nodes: [Option<Label>; 2], forces: &ForceResult) -> Self {
        let kept: Vec<usize> = (0..DOFS).filter(|j| connector.active()[*j]).collect();
        let reached = |j: &usize| connector.reach()[*j];
        let force = |(j, force): (usize, f64)| {
            let end = usize::from(j >= DOFS / 2);
            NodalForce { name: DOF[j], node: nodes[end], role: ["a", "b"][end], dof: DOF_NUMBER[j], force }
        };
        let reactions = REACTION.into_iter().zip(&forces.by_reactions);
        let columns: Vec<(&'static str, &[f64; DOFS])> = reactions
            .chain([("T2", &forces.by_beyond), ("α", &forces.by_angle)])
            .filter_map(|(name, column)| Some((name, column.as_ref()?)))
            .collect();
        let square = [&forces.geometric, &forces.derivative, &forces.tangent, &forces.damping];
        let derivatives = derivatives(&kept, square, &columns);
        let entries = forces.nodal.iter().flatten().copied().enumerate();
        Self { forces: entries.filter(|(j, _)| reached(j)).map(force).collect(), derivatives }
    }

    /// Of an MPC, by the degrees of freedom that it has.
    fn of_mpc(element: &MpcElement, forces: &MpcForces, request: &Request, kept: &[usize]) -> Self {
        let kind = element.constraint.kind();
        let wants = |output: Output| request.outputs().any(|one| one == output);
        let force = |j: &usize| {
            let (place, dof) = mpc::MpcType::column_dof(*j);
            let role = kind.entry().nodes.get(place).copied().unwrap_or_default();
            let node = element.nodes.get(place).copied();
            NodalForce { name: kind.column_name(*j), node, role, dof, force: forces.nodal[*j] }
        };
        let columns: Vec<(&'static str, &[f64; MPC_DOFS])> = forces
            .by_multipliers
            .iter()
            .enumerate()
            .filter_map(|(row, column)| Some((kind.row_name(row), column.as_ref()?)))
            .collect();
        let square = [&forces.geometric, &forces.derivative, &forces.tangent, &forces.damping];
        let derivatives = derivatives(kept, square, &columns);
        let forces = if wants(Output::NF) { kept.iter().map(force).collect() } else { Vec::new() };
        Self { forces, derivatives }
    }

    /// Of an MPC without forces, by the degrees of freedom that it has.
    fn of_springs(slopes: &MpcSlopes, kept: &[usize]) -> Self {
        let rows = |of: &mpc::force::DofMatrix<f64>| {
            kept.iter().map(|i| kept.iter().map(|j| of[*i][*j]).collect()).collect()
        };
        let square = [(Output::KT, &slopes.tangent), (Output::CT, &slopes.damping)];
        let derivatives = square
            .into_iter()
            .filter_map(|(output, of)| Some(NodalDerivative { output, by: None, rows: rows(of.as_ref()?) }));
        Self { forces: Vec::new(), derivatives: derivatives.collect() }
    }

    fn is_empty(&self) -> bool {
        self.forces.is_empty() && self.derivatives.is_empty()
    }
}

/// The tables of derivatives of nodal forces by the degrees of freedom kept: KG, DNF, KT and CT, as far as they are there, and KR by
/// columns.
fn derivatives<const N: usize>(
    kept: &[usize],
    square: [&Option<Box<[[f64; N]; N]>>; 4],
    columns: &[(&'static str, &[f64; N])],
) -> Vec<NodalDerivative> {
    let outputs = [Output::KG, Output::DNF, Output::KT, Output::CT];
    let tables = outputs.into_iter().zip(square).filter_map(|(output, of)| {
        let of = of.as_ref()?;
        let rows = kept.iter().map(|i| kept.iter().map(|j| of[*i][*j]).collect()).collect();
        Some(NodalDerivative { output, by: None, rows })
    });
    let by_reactions = (!columns.is_empty()).then(|| NodalDerivative {
        output: Output::KR,
        by: Some(columns.iter().map(|(name, _)| *name).collect()),
        rows: kept.iter().map(|i| columns.iter().map(|(_, column)| column[*i]).collect()).collect(),
    });
    tables.chain(by_reactions).collect()
}

/// Whether anything acts on the angle of a hinge, or what the constraint transmits is known.
fn acts(result: &MpcResult, i: usize) -> bool {
    let driven = result.hinges[i].is_some_and(|hinge| hinge.load.is_some() || hinge.prescribed.is_some());
    driven || result.moments[i].is_some() || result.forces.is_some()
}

/// The moments on hinges that are asked for and not known.
fn not_known_of_hinges(request: &Request, result: &MpcResult, names: &[&'static str]) -> Vec<Flag> {
    let mut flags = Vec::new();
    for (i, name) in names.iter().enumerate().filter(|(i, _)| acts(result, *i)) {
        let Some(hinge) = result.hinges.get(i).copied().flatten() else { continue };
        let own = result.moments.get(i).copied().flatten().and_then(Result::err);
        let driven = match hinge.prescribed {
            Some(Prescribed::Unknown(_, why)) => Some(why),
            _ => None,
        };
        for (output, unknown) in [
            (Output::CEF, own),
            (Output::CVF, own),
            (Output::CCF, hinge.load.and_then(Result::err)),
            (Output::CRF, hinge.reaction.err()),
            (Output::CTF, hinge.constraint.err()),
            (Output::DRIVEN, driven),
        ] {
            let is_wanted = request.outputs().any(|one| one == output);
            flags.extend(unknown.filter(|_| is_wanted).map(|why| Flag::NotKnown {
                component: name,
                quantity: output.name(),
                why: why.in_words(),
            }));
        }
    }
    flags
}

/// What a block is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockKind {
    /// A connector element.
    Connector,
    /// A multi-point constraint.
    Mpc,
    /// An equation, or what a rigid body, a coupling or a tie requires of its nodes.
    Relation,
}

/// One connector or MPC at one state: components with the outputs asked for, derivatives, what needs care.
#[derive(Clone, Debug)]
pub struct Block<'a> {
    /// What it is about.
    pub kind: BlockKind,
    /// The element number, or the nodes of an MPC.
    pub label: String,
    /// The connection type, or the type of the MPC.
    pub type_name: &'a str,
    /// The nodes by role: a and b, or those of an MPC; `None` is the ground.
    pub nodes: Vec<(&'static str, Option<Label>)>,
    /// The components that have something to show.
    pub rows: Vec<ComponentRow>,
    /// The nodal degrees of freedom that derivatives are taken by.
    pub columns: Vec<Column>,
    /// Rows of derivatives.
    pub derivatives: Vec<Derivative>,
    /// Slopes of forces, where they are asked for.
    pub tangent: Option<Tangent<f64>>,
    /// Nodal forces and their derivatives, where component forces are known and these are asked for.
    pub nodal: Nodal,
    /// The branch, where turns are asked for.
    pub branch: Option<Branch<f64>>,
    /// What an MPC tells besides.
    pub mpc: Option<MpcFacts>,
    /// What needs care.
    pub flags: Vec<Flag>,
}

/// A component.
#[derive(Clone, Debug)]
pub struct ComponentRow {
    /// u1 … ur3; angles (φJ) and equations (δ1 … ρ3) of an MPC.
    pub name: &'static str,
    /// Available, constrained, measured.
    pub role: &'static str,
    /// The unit of the position.
    pub unit: Unit,
    /// The outputs, in the order of [`Output::ALL`].
    pub values: [Option<Value>; Output::ALL.len()],
}

/// The value of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// CSLST.
    Stop(StopStatus),
    /// SLIP.
    Slip(Status),
    /// TURNS.
    Turns(Turns<f64>),
    /// MARGIN.
    Margin(Margin),
}

impl Value {
    /// The value as one number.
    pub const fn number(self) -> f64 {
        match self {
            Self::Number(number) => number,
            Self::Stop(StopStatus::Free) => 0.0,
            Self::Stop(_) => 1.0,
            Self::Slip(Status::Stick) => 0.0,
            Self::Slip(Status::Slip) => 1.0,
            Self::Slip(Status::Free) => 2.0,
            Self::Turns(turns) => turns.turns,
            Self::Margin(margin) => margin.distance,
        }
    }
}

/// A nodal degree of freedom.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Column {
    /// xa1, θb3, Ψb …
    pub name: &'static str,
    /// The node.
    pub node: Label,
    /// The node's role.
    pub role: &'static str,
    /// The number of the degree of freedom, 1 to 6 or 10.
    pub dof: u8,
}

/// A row of derivatives by the columns of its block.
#[derive(Clone, Debug)]
pub struct Derivative {
    /// The component.
    pub component: &'static str,
    /// The printed constraint that is differentiated, where it is not the position.
    pub printed: Option<&'static str>,
    /// First derivatives.
    pub gradient: Vec<f64>,
    /// Second derivatives.
    pub hessian: Option<Vec<Vec<f64>>>,
}

impl Derivative {
    /// The entries of a row, and of its second derivatives, that are kept.
    fn of<const N: usize>(
        component: &'static str,
        kept: &[usize],
        row: &[f64; N],
        hessian: Option<&[[f64; N]; N]>,
    ) -> Self {
        let of_row = |row: &[f64; N]| kept.iter().map(|j| row[*j]).collect::<Vec<f64>>();
        let hessian = hessian.map(|hessian| kept.iter().map(|i| of_row(&hessian[*i])).collect());
        Self { component, printed: None, gradient: of_row(row), hessian }
    }
}

/// What an MPC tells besides its rows.
#[derive(Clone, Debug)]
pub struct MpcFacts {
    /// Its hinges.
    pub hinges: Vec<HingeFacts>,
    /// How far the relative rotation is from what the hinges allow, in radians; `None` without hinges.
    pub misalignment: Option<f64>,
}

/// A hinge of an MPC.
#[derive(Clone, Copy, Debug)]
pub struct HingeFacts {
    /// The name of its angle.
    pub name: &'static str,
    /// The angle as the state gives it, degree of freedom 6 of its node, in radians.
    pub given: Option<f64>,
    /// The axis as it is carried, global components.
    pub axis: [f64; 3],
    /// What springs and dashpots to ground do to it, or why that is not known.
    pub moments: Option<Result<HingeMoments, Unknown>>,
    /// M_J, what the constraint puts on it, residual-side, where something acts on it or forces are given, and it is known.
    pub constraint: Option<f64>,
}

const NO_VALUES: [Option<Value>; Output::ALL.len()] = [None; Output::ALL.len()];

/// The value of an output of component k (0-based) of a connector; `None` where there is none, or it is no number of a component.
pub fn value_of(result: &ConnectorResult, output: Output, k: usize) -> Option<Value> {
    let (forces, behavior) = (result.forces.as_deref(), result.behavior.as_deref());
    let number = |value: Option<f64>| value.map(Value::Number);
    match output {
        Output::CSLST => result.stops[k].map(Value::Stop),
        Output::TURNS => result.evaluation.turns[k].map(Value::Turns),
        Output::MARGIN => result.margins[k].map(Value::Margin),
        Output::CTF => number(
            forces
                .and_then(|forces| forces.components[k])
                .or(behavior.and_then(|outcome| outcome.total.value[k])),
        ),
        Output::PM => number(forces.and_then(|forces| forces.printed[k])),
        Output::LM => number(forces.and_then(|forces| forces.multipliers[k])),
        of_motion if of_motion.is_of_motion() => number(result.evaluation.value(of_motion, k)),
        of_slopes if of_slopes.is_nodal() || of_slopes == Output::TANGENT => None,
        of_behavior => behavior.and_then(|outcome| force(outcome, of_behavior, k)),
    }
}

impl<'a> Block<'a> {
    /// A connector.
    pub fn of_connector(model: &'a Model, request: &Request, result: &ConnectorResult) -> Self {
        let element = &model.connectors[result.index];
        let connector = &element.connector;
        let connection = connector.connection();
        let evaluation = &result.evaluation;
        let forces = result.forces.as_deref();
        let kept: Vec<usize> = (0..DOFS).filter(|j| connector.active()[*j]).collect();
        let mut rows = Vec::new();
        let mut derivatives = Vec::new();
        for k in 0..6 {
            let slot = connection.slots[k];
            let Some(position) = slot.position() else { continue };
            let values =
                Output::ALL.map(|output| value_of(result, output, k).filter(|_| request.wants(output, k)));
            if values != NO_VALUES {
                rows.push(ComponentRow {
                    name: COMPONENT[k],
                    role: words::role(slot),
                    unit: position.unit(),
                    values,
                });
            }
            if let Some(row) = &evaluation.jacobian[k] {
                let printed = connector.differentiated(k).filter(|_| connector.is_printed_constraint(k));
                let kept = Derivative::of(COMPONENT[k], &kept, row, evaluation.hessian[k].as_deref());
                derivatives.push(Derivative { printed: printed.map(|measure| measure.formula()), ..kept });
            }
        }
        rows.extend(result.behavior.iter().flat_map(|outcome| coupled(outcome, request)));
        let columns = kept.into_iter().filter_map(|j| {
            let end = usize::from(j >= DOFS / 2);
            let node = element.nodes[end]?;
            Some(Column { name: DOF[j], node, role: ["a", "b"][end], dof: DOF_NUMBER[j] })
        });
        let wants_turns = request.outputs().any(|output| output == Output::TURNS);
        Self {
            kind: BlockKind::Connector,
            label: element.label.to_string(),
            type_name: &connection.name,
            nodes: vec![("a", element.nodes[0]), ("b", element.nodes[1])],
            rows,
            columns: columns.collect(),
            derivatives,
            tangent: result.tangent.as_deref().cloned(),
            nodal: forces.map(|forces| Nodal::of(connector, element.nodes, forces)).unwrap_or_default(),
            branch: wants_turns.then_some(evaluation.branch),
            mpc: None,
            flags: result.flags.clone(),
        }
        .with_what_is_not_finite()
    }

    /// A relation.
    pub fn of_relation(model: &'a Model, request: &Request, result: &RelationResult) -> Self {
        let element = &model.relations[result.index];
        let relation = &element.relation;
        let wanted = |output: Output| request.outputs().any(|wanted| wanted == output);
        let mut rows = Vec::new();
        let mut derivatives = Vec::new();
        for ((name, unit), row) in relation.rows().into_iter().zip(&result.rows) {
            let value = |output| match output {
                Output::RES => Some(row.residual),
                Output::RESV => row.rate,
                Output::RESB => row.bias,
                Output::RESA => row.acceleration,
                _ => None,
            };
            let values =
                Output::ALL.map(|output| value(output).filter(|_| wanted(output)).map(Value::Number));
            if values != NO_VALUES {
                rows.push(ComponentRow { name, role: "constrained", unit, values });
            }
            if !row.gradient.is_empty() {
                let gradient = row.gradient.clone();
                derivatives.push(Derivative { component: name, printed: None, gradient, hessian: None });
            }
        }
        let column = |(place, dof): &(usize, u8)| {
            let (name, role) = (relation.column_name(*place, *dof), relation.role(*place));
            Some(Column { name, node: *element.nodes.get(*place)?, role, dof: *dof })
        };
        let nodes = element.nodes.iter().enumerate().map(|(place, node)| (relation.role(place), Some(*node)));
        Self {
            kind: BlockKind::Relation,
            label: element.label.clone(),
            type_name: element.type_name,
            nodes: nodes.collect(),
            rows,
            columns: relation.columns().iter().filter_map(column).collect(),
            derivatives,
            tangent: None,
            nodal: Nodal::default(),
            branch: None,
            mpc: None,
            flags: result.flags.clone(),
        }
        .with_what_is_not_finite()
    }

    /// An MPC: the angles of its hinges that the rotations imply, and its equations.
    pub fn of_mpc(model: &Model, request: &Request, result: &MpcResult) -> Self {
        let element = &model.mpcs[result.index];
        let (constraint, evaluation) = (&element.constraint, &result.evaluation);
        let kind = constraint.kind();
        let entry = kind.entry();
        let wanted = |output: Output| request.outputs().any(|wanted| wanted == output);
        let values = |of: &dyn Fn(Output) -> Option<Value>| {
            Output::ALL.map(|output| of(output).filter(|_| wanted(output)))
        };
        let number = |value: Option<f64>| value.map(Value::Number);
        let mut rows = Vec::new();
        for (i, name) in entry.angles.iter().enumerate() {
            let turns = evaluation.angles[i];
            let angle = f64::with_turns(turns.principal, turns.turns);
            let rate = |order: usize| evaluation.angle_rates.map(|rates| rates[i][order]);
            let hinge = result.hinges[i];
            let own = result.moments[i].and_then(Result::ok);
            let values = values(&|output| match output {
                Output::CP | Output::CU => Some(Value::Number(angle)),
                Output::CV => number(rate(0)),
                Output::CA => number(rate(1)),
                Output::TURNS => Some(Value::Turns(turns)),
                Output::MARGIN => result.margins.angles[i].map(Value::Margin),
                Output::CEF => number(own.map(|moments| moments.spring)),
                Output::CVF => number(own.and_then(|moments| moments.dashpot)),
                Output::CCF => number(hinge?.load?.ok()),
                Output::CRF => number(hinge.filter(|_| acts(result, i))?.reaction.ok()),
                Output::CTF => {
                    number(hinge.filter(|_| acts(result, i))?.constraint.ok().map(|moment| -moment))
                }
                Output::DRIVEN => number(hinge?.prescribed?.value().1),
                Output::RES => number(hinge?.residual[0]),
                Output::RESV => number(hinge?.residual[1]),
                Output::RESA => number(hinge?.residual[2]),
                _ => None,
            });
            rows.push(ComponentRow { name, role: "available", unit: Unit::Angle, values });
        }
        let equations: Vec<usize> = (0..MPC_ROWS).filter(|row| constraint.rows()[*row]).collect();
        for row in equations.iter().copied() {
            let values = values(&|output| match output {
                Output::RES => number(evaluation.residual[row]),
                Output::RESV => number(evaluation.residual_rate[row]),
                Output::RESB => number(evaluation.residual_bias[row]),
                Output::RESA => number(evaluation.residual_acceleration[row]),
                Output::MARGIN => result.margins.rows[row].map(Value::Margin),
                Output::LM => number(result.forces.as_ref().and_then(|forces| forces.multipliers[row])),
                _ => None,
            });
            let (name, unit) = (kind.row_name(row), mpc::MpcType::row_unit(row));
            rows.push(ComponentRow { name, role: "constrained", unit, values });
        }
        rows.retain(|row| row.values != NO_VALUES);
        let kept: Vec<usize> = (0..MPC_DOFS).filter(|j| constraint.columns()[*j]).collect();
        let columns = kept.iter().filter_map(|j| {
            let (place, dof) = mpc::MpcType::column_dof(*j);
            let (node, role) = (*element.nodes.get(place)?, *entry.nodes.get(place)?);
            Some(Column { name: kind.column_name(*j), node, role, dof })
        });
        let derivatives = equations.iter().filter_map(|row| {
            let gradient = evaluation.jacobian[*row].as_ref()?;
            Some(Derivative::of(kind.row_name(*row), &kept, gradient, evaluation.hessian[*row].as_deref()))
        });
        let hinges = entry.angles.iter().enumerate().filter_map(|(i, name)| {
            let (given, moments) = (result.given[i], result.moments[i]);
            let constraint =
                result.hinges[i].filter(|_| acts(result, i)).and_then(|hinge| hinge.constraint.ok());
            Some(HingeFacts { name, given, axis: evaluation.axes[i]?, moments, constraint })
        });
        let nodal = result.forces.as_deref().map(|forces| Nodal::of_mpc(element, forces, request, &kept));
        let nodal = nodal.or_else(|| result.slopes.as_deref().map(|slopes| Nodal::of_springs(slopes, &kept)));
        let mut flags = result.flags.clone();
        flags.extend(not_known_of_hinges(request, result, entry.angles));
        Self {
            kind: BlockKind::Mpc,
            label: element.label(),
            type_name: entry.name,
            nodes: entry.nodes.iter().copied().zip(element.nodes.iter().copied().map(Some)).collect(),
            rows,
            columns: columns.collect(),
            derivatives: derivatives.collect(),
            tangent: None,
            nodal: nodal.unwrap_or_default(),
            branch: None,
            mpc: Some(MpcFacts { hinges: hinges.collect(), misalignment: result.misalignment }),
            flags,
        }
        .with_what_is_not_finite()
    }

    fn with_what_is_not_finite(mut self) -> Self {
        for row in &self.rows {
            for (output, value) in Output::ALL.into_iter().zip(&row.values) {
                if value.is_some_and(|value| !value.number().is_finite()) {
                    self.flags.push(Flag::NotFinite { component: row.name, quantity: output.name() });
                }
            }
        }
        for force in self.nodal.forces.iter().filter(|force| !force.force.is_finite()) {
            self.flags.push(Flag::NotFinite { component: force.name, quantity: Output::NF.name() });
        }
        for NodalDerivative { output, rows, .. } in &self.nodal.derivatives {
            let (rows, dofs) = (rows.iter(), self.columns.iter());
            let broken = rows.zip(dofs).filter(|(row, _)| row.iter().any(|entry| !entry.is_finite()));
            self.flags.extend(
                broken.map(|(_, dof)| Flag::NotFinite { component: dof.name, quantity: output.name() }),
            );
        }
        for derivative in &self.derivatives {
            let second = derivative.hessian.iter().flatten().flatten();
            if derivative.gradient.iter().chain(second).any(|entry| !entry.is_finite()) {
                self.flags.push(Flag::NotFinite { component: derivative.component, quantity: "derivative" });
            }
        }
        self
    }

    /// Whether there is a number to show.
    pub fn has_numbers(&self) -> bool {
        !(self.rows.is_empty()
            && self.derivatives.is_empty()
            && self.nodal.is_empty()
            && self.tangent.is_none())
    }

    /// Whether there is nothing to show: neither a number, nor a reason why one is missing.
    pub fn is_empty(&self) -> bool {
        let is_missing = self.flags.iter().any(|flag| matches!(flag, Flag::NotKnown { .. }));
        !self.has_numbers() && !is_missing
    }

    /// `HINGE 101`, `MPC REVOLUTE`.
    pub fn title(&self) -> String {
        match self.kind {
            BlockKind::Connector => format!("{} {}", self.type_name, self.label),
            BlockKind::Mpc => format!("MPC {}", self.type_name),
            BlockKind::Relation => self.type_name.to_string(),
        }
    }

    /// The outputs that at least one row has, in the order of [`Output::ALL`].
    pub fn outputs(&self) -> Vec<Output> {
        let has = |output: &Output| self.rows.iter().any(|row| row.values[*output as usize].is_some());
        Output::ALL.into_iter().filter(has).collect()
    }
}

/// The names of component forces.
pub(crate) const FORCE: [&str; 6] = ["f1", "f2", "f3", "m1", "m2", "m3"];

/// The names of reactions.
const REACTION: [&str; 6] = ["CRF1", "CRF2", "CRF3", "CRM1", "CRM2", "CRM3"];

/// The names of component velocities.
const VELOCITY: [&str; 6] = ["v1", "v2", "v3", "vr1", "vr2", "vr3"];

/// The positions on which an angle of wrap depends: of node a, of the ring b, and of c, where the segment beyond ends.
const WRAP: [&str; 9] = ["xa1", "xa2", "xa3", "xb1", "xb2", "xb3", "xc1", "xc2", "xc3"];

/// The slopes that are not zero: force, by what (u, v, CRF, the tension T2 beyond a ring and the measured angle of wrap α there, the
/// time step dt), slope; then those of α by positions.
pub(crate) fn slopes(tangent: &Tangent<f64>) -> Vec<(&'static str, &'static str, f64)> {
    let mut all = Vec::new();
    for i in 0..6 {
        let of = |names: [&'static str; 6], line: [f64; 6]| names.into_iter().zip(line);
        let by = of(COMPONENT, tangent.displacement[i])
            .chain(of(VELOCITY, tangent.velocity[i]))
            .chain(of(REACTION, tangent.reaction[i]))
            .chain([("T2", tangent.beyond[i]), ("α", tangent.angle[i]), ("dt", tangent.time[i])]);
        all.extend(by.map(|(name, slope)| (FORCE[i], name, slope)));
    }
    let places = tangent.wrap.iter().flatten().flatten();
    all.extend(WRAP.into_iter().zip(places).map(|(place, slope)| ("α", place, *slope)));
    all.retain(|(_, _, slope)| *slope != 0.0);
    all
}

/// An output of one friction in an increment that has a duration, or has none.
fn sliding(slip: &friction::FrictionOutcome<f64>, duration: Option<f64>, output: Output) -> Option<Value> {
    Some(Value::Number(match output {
        Output::CSF => slip.tangential,
        Output::CNF => slip.normal,
        Output::CASU => slip.accumulated_slip,
        Output::CIVC => duration.map(|_| slip.slip_rate)?,
        Output::SLIP => return Some(Value::Slip(slip.status)),
        _ => return None,
    }))
}

/// The rows of frictions that several components share: CSFC, CNFC, CASUC, CIVC, SLIP.
fn coupled(outcome: &Outcome, request: &Request) -> Vec<ComponentRow> {
    let wanted = |output: Output| request.outputs().any(|one| one == output);
    let shared = outcome.slips.iter().filter(|slip| slip.components.iter().filter(|one| **one).count() > 1);
    let row = |slip: &friction::FrictionOutcome<f64>| ComponentRow {
        name: "C",
        role: "slip",
        unit: Unit::Length,
        values: Output::ALL.map(|output| sliding(slip, outcome.duration, output).filter(|_| wanted(output))),
    };
    let rows = shared.filter_map(|slip| Some(row(slip.outcome.as_ref().ok()?)));
    rows.filter(|row| row.values != NO_VALUES).collect()
}

/// An output of behaviour.
fn force(outcome: &Outcome, output: Output, k: usize) -> Option<Value> {
    let number = |forces: &Forces<f64>| forces.value[k].map(Value::Number);
    match output {
        Output::CTF => number(&outcome.total),
        Output::CEF => number(&outcome.elastic),
        Output::CVF => number(&outcome.viscous),
        Output::CRF => number(&outcome.reaction),
        Output::CSF => number(&outcome.friction),
        Output::CCF => number(&outcome.load),
        Output::CNF | Output::CASU | Output::CIVC | Output::SLIP => {
            // A coupled friction has them once, in a row of its own.
            let alone = [0, 1, 2, 3, 4, 5].map(|j| j == k);
            let slip = outcome.slips.iter().find(|slip| slip.components == alone)?;
            sliding(slip.outcome.as_ref().ok()?, outcome.duration, output)
        }
        Output::CFAILST => Some(Value::Number(f64::from(u8::from(outcome.failed[k])))),
        Output::DRIVEN => outcome.prescribed[k]?.value().1.map(Value::Number),
        _ => None,
    }
}

/// A node in words.
pub(crate) fn node_name(node: Option<Label>) -> String {
    node.map_or_else(|| "ground".to_string(), |label| label.to_string())
}
