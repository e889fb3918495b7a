//! What acts on the angles of hinges, and what a multi-point constraint transmits under given forces on its first node.

use crate::behavior::drive::{ANGLE, Drives, Prescribed, Schedule};
use crate::behavior::{PRINTED, Unknown};
use crate::evaluate::mpc::{HingeMoments, MpcElement};
use num_dual::Dual2_64;
use pintle_kinematics::catalog::FORCE;
use pintle_kinematics::connector::{Components, Flag, Output, Request};
use pintle_kinematics::mpc::force::DofMatrix;
use pintle_kinematics::mpc::{DOFS, Dofs, Evaluation, FLOW, MpcType, PHI, ROWS, Rows, State, XS, force};
use pintle_scene::{Code, ElementForces, ForceSign};

/// What acts on the angle of a hinge. Moments are internal, as component forces: CTF = CEF + CVF + CRF − CCF, and the moment M_J
/// that the constraint puts on the hinge is minus that.
#[derive(Clone, Copy, Debug)]
pub struct Hinge {
    /// CCF: the concentrated moment, positive drives the angle; `None` where there is none.
    pub load: Option<Result<f64, Unknown>>,
    /// What a boundary condition prescribes.
    pub prescribed: Option<Prescribed<f64>>,
    /// What it enforces to be zero, with its rate and acceleration, as far as they are enforced and known.
    pub residual: [Option<f64>; 3],
    /// CRF: what a boundary condition takes; zero without one.
    pub reaction: Result<f64, Unknown>,
    /// M_J, residual-side.
    pub constraint: Result<f64, Unknown>,
}

/// What a constraint transmits; each part is present where it was asked for.
#[derive(Clone, Debug)]
pub struct MpcForces {
    /// LM: one multiplier λ for each equation.
    pub multipliers: Rows<f64>,
    /// NF: Jᵀλ, residual-side, on all degrees of freedom.
    pub nodal: Dofs<f64>,
    /// KG: Σ λ ∂²g.
    pub geometric: Option<DofMatrix<f64>>,
    /// DNF: ∂NF/∂q at constant multipliers.
    pub derivative: Option<DofMatrix<f64>>,
    /// KT: KG and the stiffness of springs on the angles.
    pub tangent: Option<DofMatrix<f64>>,
    /// CT: the damping of dashpots on the angles.
    pub damping: Option<DofMatrix<f64>>,
    /// KR: the columns ∂NF/∂λ, the rows of the equations.
    pub by_multipliers: Rows<Dofs<f64>>,
}

/// What springs and dashpots on the angles of hinges do, where the forces on the constraint are not given.
#[derive(Clone, Debug)]
pub struct MpcSlopes {
    /// KT, without KG: the stiffness of springs alone.
    pub tangent: Option<DofMatrix<f64>>,
    /// CT: the damping of dashpots.
    pub damping: Option<DofMatrix<f64>>,
}

/// The moments of springs and dashpots on the angles of both hinges, as far as they are known.
type Moments = [Option<Result<HingeMoments, Unknown>>; 2];

impl MpcSlopes {
    /// Those that are asked for, and that KT lacks KG; nothing where no spring or dashpot acts.
    pub(in crate::evaluate) fn of(moments: &Moments, request: &Request) -> (Option<Self>, Option<Flag>) {
        let wants = |output: Output| request.outputs().any(|one| one == output);
        let acts = moments.iter().flatten().any(Result::is_ok);
        if !acts || !(wants(Output::KT) || wants(Output::CT)) {
            return (None, None);
        }
        let flag = wants(Output::KT).then_some(Flag::NotKnown {
            component: "all",
            quantity: Output::KG.name(),
            why: "no forces are given on its first node, so that KT is the stiffness of its springs alone",
        });
        let tangent = wants(Output::KT).then(|| on_angles(moments, |moments| Some(moments.stiffness)));
        let damping = wants(Output::CT).then(|| on_angles(moments, |moments| moments.damping));
        (Some(Self { tangent, damping }), flag)
    }
}

/// Slopes on the angles of hinges, as a matrix.
fn on_angles(moments: &Moments, of: fn(&HingeMoments) -> Option<f64>) -> DofMatrix<f64> {
    let mut matrix: DofMatrix<f64> = Box::new([[0.0; DOFS]; DOFS]);
    for (i, moments) in moments.iter().enumerate() {
        let slope = moments.and_then(Result::ok).and_then(|moments| of(&moments));
        matrix[PHI + i][PHI + i] = slope.unwrap_or(0.0);
    }
    matrix
}

/// Why a sum of forces is not known.
pub(in crate::evaluate) const NOT_GIVEN: &str =
    "the force of this component is neither given nor told by its behaviour";

/// The order of derivatives that a request of forces needs.
pub(in crate::evaluate) fn order(request: &Request) -> u8 {
    let needs = |output: Output| match output {
        Output::NF | Output::LM | Output::KR | Output::CTF | Output::CRF => 1,
        Output::KG | Output::DNF | Output::KT => 2,
        _ => 0,
    };
    request.outputs().map(needs).max().unwrap_or(0)
}

/// The forces and moments that a constraint puts on its first node, as given: zero where it transmits none, none where none is given.
///
/// # Errors
/// One that it does not transmit and is not zero: code, message, remedy.
pub(in crate::evaluate) fn given_forces(
    element: &MpcElement,
    given: &ElementForces,
) -> Result<Components<f64>, (Code, String, String)> {
    let transmits = transmitted(element.constraint.kind());
    let list: Vec<&str> = (0..6).filter(|k| transmits[*k]).map(|k| FORCE[k]).collect();
    let list = list.join(", ");
    let sign = if given.sign == ForceSign::ConstraintsOnB { -1.0 } else { 1.0 };
    let mut forces = [Some(0.0); 6];
    for k in 0..6 {
        let value = given.total[k].or(given.reaction[k]);
        match value {
            Some(value) if !transmits[k] && value != 0.0 => {
                let message = format!("it transmits no {}", FORCE[k]);
                let remedy = format!("leave it out, or write 0; it transmits {list}");
                return Err((Code::ForcesAbsentComponent, message, remedy));
            }
            _ if transmits[k] => forces[k] = value.map(|value| sign * value),
            _ => {}
        }
    }
    Ok(forces)
}

/// Forces and moments as those of the first node; none where one is not given.
pub(in crate::evaluate) fn on_first_node(forces: Components<f64>) -> Option<Dofs<f64>> {
    let mut of_node = [0.0; DOFS];
    for (place, force) in of_node.iter_mut().skip(XS).zip(forces) {
        *place = force?;
    }
    Some(of_node)
}

/// Which of f1 … m3 a kind transmits.
fn transmitted(kind: MpcType) -> [bool; 6] {
    let rows = kind.rows(false);
    let moves = rows[0];
    [moves, moves, moves, rows[3], rows[4], rows[5]]
}

impl MpcForces {
    /// What is transmitted when the constraint puts these forces on its first node.
    pub(in crate::evaluate) fn of(
        element: &MpcElement,
        (state, evaluation): (&State<f64>, &Evaluation<f64>),
        given: &Dofs<f64>,
        moments: &Moments,
        request: &Request,
        flags: &mut Vec<Flag>,
    ) -> Self {
        let constraint = &element.constraint;
        let multipliers = constraint.multipliers(state, evaluation, given);
        let mut multipliers = multipliers;
        multipliers[FLOW] = None;
        let nodal = evaluation.nodal(&multipliers);
        let largest = given.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
        for j in XS..XS + 6 {
            let by = given[j] - nodal[j];
            if by.abs() > PRINTED * largest {
                let component = constraint.kind().column_name(j);
                flags.push(Flag::OutOfBalance { component, by });
            }
        }
        let wants = |output: Output| request.outputs().any(|one| one == output);
        let needs_geometric = wants(Output::KG) || wants(Output::KT);
        let geometric = needs_geometric.then(|| evaluation.geometric_stiffness(&multipliers));
        let tangent = geometric.as_ref().filter(|_| wants(Output::KT)).map(|geometric| {
            let mut sum = geometric.clone();
            let springs = on_angles(moments, |moments| Some(moments.stiffness));
            for i in [PHI, PHI + 1] {
                sum[i][i] += springs[i][i];
            }
            sum
        });
        let damping = wants(Output::CT).then(|| on_angles(moments, |moments| moments.damping));
        Self {
            multipliers,
            nodal,
            geometric: geometric.filter(|_| wants(Output::KG)),
            derivative: wants(Output::DNF).then(|| evaluation.derivative(&multipliers)),
            tangent,
            damping,
            by_multipliers: if wants(Output::KR) { evaluation.jacobian } else { [None; ROWS] },
        }
    }
}

impl Hinge {
    /// The hinge at a time, where its angle is this one, with its rates as far as they are known.
    pub(in crate::evaluate) fn at(
        drives: &Drives,
        (schedule, time): (&Schedule, Option<f64>),
        angle: [Option<f64>; 3],
        moments: Option<Result<HingeMoments, Unknown>>,
        transmitted: Option<f64>,
    ) -> Self {
        let load = drives.loads[ANGLE].as_ref().map(|drive| drive.load(schedule, time));
        let on_time = time.map(|time| Dual2_64::new(time, 1.0, 0.0));
        let prescribed =
            drives.motions[ANGLE].as_ref().and_then(|drive| drive.at(schedule, on_time, |_| None));
        let minus = |k: usize, wanted: f64| angle[k].map(|value| value - wanted);
        let residual = match prescribed {
            Some(Prescribed::Displacement(wanted)) => {
                [minus(0, wanted.re), minus(1, wanted.v1), minus(2, wanted.v2)]
            }
            Some(Prescribed::Velocity(wanted)) => [None, minus(1, wanted.re), minus(2, wanted.v1)],
            Some(Prescribed::Acceleration(wanted)) => [None, None, minus(2, wanted.re)],
            Some(Prescribed::Unknown(..)) | None => [None; 3],
        };
        let own = internal(moments).and_then(|own| Ok(own - load.unwrap_or(Ok(0.0))?));
        let (reaction, constraint) = match (transmitted, prescribed) {
            (Some(moment), None) => (Ok(0.0), Ok(moment)),
            (Some(moment), Some(_)) => (own.map(|own| -moment - own), Ok(moment)),
            (None, None) => (Ok(0.0), own.map(|own| -own)),
            (None, Some(_)) => (Err(Unknown::Reaction), Err(Unknown::Reaction)),
        };
        let prescribed = prescribed.map(Prescribed::real);
        Self { load, prescribed, residual, reaction, constraint }
    }

    /// How far what acts on an angle that nothing prescribes is from what the constraint puts there.
    pub(in crate::evaluate) fn out_of_balance(
        &self,
        moments: Option<Result<HingeMoments, Unknown>>,
    ) -> Option<f64> {
        if self.prescribed.is_some() {
            return None;
        }
        let load = self.load.unwrap_or(Ok(0.0)).ok()?;
        let (own, constraint) = (internal(moments).ok()?, self.constraint.ok()?);
        let by = constraint + own - load;
        (by.abs() > PRINTED * (constraint.abs() + own.abs() + load.abs())).then_some(by)
    }
}

/// CEF + CVF of springs and dashpots.
fn internal(moments: Option<Result<HingeMoments, Unknown>>) -> Result<f64, Unknown> {
    let Some(moments) = moments else { return Ok(0.0) };
    let moments = moments?;
    match moments.dashpot {
        Some(dashpot) => Ok(moments.spring + dashpot),
        None if moments.has_dashpot => Err(Unknown::Rate),
        None => Ok(moments.spring),
    }
}

/// The moments that a constraint puts on its hinges.
pub(in crate::evaluate) fn on_hinges(forces: Option<&MpcForces>) -> [Option<f64>; 2] {
    forces.map_or([None; 2], |forces| force::hinge_moments(&forces.nodal).map(Some))
}
