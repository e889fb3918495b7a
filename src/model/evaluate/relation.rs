//! The relations of a scene: equations, rigid bodies, couplings and ties, resolved once, evaluated at a state.
//!
//! A rigid body and a kinematic coupling are a relation for each of their nodes, a tie one for each degree of freedom of a pair. So what they
//! cost grows with the number of nodes.

use crate::evaluate::mpc::MpcElement;
use crate::evaluate::plane;
use crate::evaluate::sequence::nodes::Moved;
use pintle_kinematics::catalog::in_plane;
use pintle_kinematics::connector::{Flag, Holding, Output, Request, Tally};
use pintle_kinematics::measure::SingularClass;
use pintle_kinematics::relation::{ConstraintRow, Form, Point, Quantity, Relation};
use pintle_kinematics::vector::Vector;
use pintle_scene::{Coupling, CouplingKind, Diagnostic, GLOBAL, Label, LabelSet, NodeFreedom, Scene, Span};

/// Below this distance from half a turn (rad) a rotation that is fixed is flagged.
const NEAR_HALF_TURN: f64 = pintle_kinematics::connector::ILL_CONDITIONED;

/// A relation between nodes, ready to be evaluated.
#[derive(Clone, Debug)]
pub struct RelationElement {
    /// What it is of: `EQUATION`, `RIGID BODY`, `KINEMATIC COUPLING`, `DISTRIBUTING COUPLING`, `TIE`.
    pub type_name: &'static str,
    /// Its nodes, in the order of its form.
    pub nodes: Vec<Label>,
    /// The relation.
    pub relation: Relation<f64>,
    /// Its nodes as one word: `10-20`; with the degrees of freedom of an equation, `10(1)-20(1)`.
    pub label: String,
    /// Where it was read.
    pub span: Span,
}

/// One relation at one state.
#[derive(Clone, Debug)]
pub struct RelationResult {
    /// Its index in the model.
    pub index: usize,
    /// Its nodes.
    pub nodes: Vec<Point<f64>>,
    /// The numbers of each equation.
    pub rows: Vec<ConstraintRow<f64>>,
    /// What needs care.
    pub flags: Vec<Flag>,
}

impl RelationElement {
    /// What it is of, and its nodes: `RIGID BODY 10-20`.
    pub fn title(&self) -> String {
        format!("{} {}", self.type_name, self.label)
    }

    /// Whether the rotation vectors of its nodes matter, with their turns.
    pub(super) fn follows_turns(&self) -> bool {
        let Form::Linear(terms) = self.relation.form() else { return false };
        terms.iter().any(|term| term.quantity == Quantity::Rotation)
    }

    /// The distance of its nodes, or what stands for it.
    pub fn length(&self) -> f64 {
        use pintle_kinematics::scalar::elementary::norm;
        match self.relation.form() {
            Form::Linear(_) => 0.0,
            Form::Carried { arm, .. } => norm(*arm),
            Form::Mean { lever, shares, .. } => {
                shares.iter().map(|share| norm(share.arm)).fold(norm(*lever), f64::max)
            }
        }
    }

    /// A node where it is.
    fn point(moved: &Moved) -> Point<f64> {
        Point {
            displacement: moved.displacement,
            rotation: moved.rotation,
            vector: moved.vector,
            flow: moved.flow,
            velocity: moved.rates,
            acceleration: moved.accelerations,
        }
    }

    /// Evaluates it with its nodes, in their order, where they are.
    pub(super) fn evaluate<'m>(
        &self,
        index: usize,
        nodes: impl Iterator<Item = &'m Moved>,
        request: &Request,
        tally: &mut Tally,
    ) -> RelationResult {
        let nodes: Vec<Point<f64>> = nodes.map(Self::point).collect();
        let rows = self.relation.evaluate(&nodes, request, tally);
        let mut flags = Vec::new();
        if let Some(distance) =
            self.relation.to_half_turn(&nodes).filter(|distance| *distance < NEAR_HALF_TURN)
        {
            let (component, at) = ("ρ1", "S turned by π from where the constraint has it");
            let class = SingularClass::BranchCut;
            flags.push(if distance <= 0.0 {
                Flag::Singular { component, at, class }
            } else {
                Flag::IllConditioned { component, at, class, distance }
            });
        }
        for ((component, _), row) in self.relation.rows().into_iter().zip(&rows) {
            let numbers = [
                (Output::RES, Some(row.residual)),
                (Output::RESV, row.rate),
                (Output::RESB, row.bias),
                (Output::RESA, row.acceleration),
            ];
            for (output, _) in
                numbers.into_iter().filter(|(_, number)| number.is_some_and(|x| !x.is_finite()))
            {
                flags.push(Flag::NotFinite { component, quantity: output.name() });
            }
            if row.gradient.iter().any(|x| !x.is_finite()) {
                flags.push(Flag::NotFinite { component, quantity: "derivative" });
            }
        }
        let named = self.relation.rows().into_iter().map(|(component, _)| component).zip(&rows);
        flags.extend(named.zip(self.relation.sizes(&nodes)).filter_map(|((component, row), size)| {
            Flag::off(component, Holding::Constraint, row.residual, size)
        }));
        RelationResult { index, nodes, rows, flags }
    }
}

/// What makes the relations of a scene.
struct Builder<'a> {
    scene: &'a Scene,
    freedom: &'a NodeFreedom,
    /// Nodes of which degree of freedom 6 is the angle of a hinge.
    hinges: LabelSet,
    found: Vec<RelationElement>,
}

impl Builder<'_> {
    fn position(&self, node: Label) -> Vector<f64> {
        self.scene.nodes.get(&node).map_or([0.0; 3], |node| node.coordinates)
    }

    fn turns(&self, node: Label) -> bool {
        self.freedom.rotates(node) && !self.hinges.contains(&node) && !self.scene.two_dimensional
    }

    /// Keeps a relation, in the plane where the model has two dimensions. One that says nothing there is none.
    fn push(&mut self, mut element: RelationElement) {
        if self.scene.two_dimensional {
            element.relation = element.relation.in_plane();
        }
        if !element.relation.rows().is_empty() {
            self.found.push(element);
        }
    }

    /// A linear equation of terms (node, degree of freedom, factor), along the axes of each node.
    fn linear(
        &mut self,
        type_name: &'static str,
        terms: &[(Label, u8, f64)],
        axes_of: impl Fn(Label) -> Result<[Vector<f64>; 3], Diagnostic>,
        span: Span,
    ) -> Result<(), Diagnostic> {
        /// Terms of an equation that its name tells.
        const TOLD: usize = 6;
        let mut nodes: Vec<Label> = Vec::new();
        let mut given = Vec::with_capacity(terms.len());
        let has = |number: u8| !self.scene.two_dimensional || in_plane(number);
        for (node, number, factor) in terms.iter().filter(|term| has(term.1)) {
            let place = nodes.iter().position(|known| known == node).unwrap_or_else(|| {
                nodes.push(*node);
                nodes.len() - 1
            });
            let at = if *number == 10 { 6 } else { usize::from(*number) - 1 };
            let axes = axes_of(*node)?;
            given.push((place, axes[at % 3], at, *factor));
        }
        if given.is_empty() {
            return Ok(());
        }
        // A single angle is along a global axis.
        let is_turned =
            |place: usize| given.iter().any(|term| term.0 == place && term.1 != GLOBAL[term.2 % 3]);
        let relation =
            Relation::linear(&given).with_angles(|place| self.turns(nodes[place]) || is_turned(place));
        let told: Vec<String> =
            terms.iter().take(TOLD).map(|(node, number, _)| format!("{node}({number})")).collect();
        let more = if terms.len() > TOLD { "-…" } else { "" };
        let label = told.join("-") + more;
        self.push(RelationElement { type_name, nodes, relation, label, span });
        Ok(())
    }

    /// S carried by M; the rotations of S are free where it has none.
    fn carried(
        &mut self,
        type_name: &'static str,
        [slave, master]: [Label; 2],
        (axes, mut fixed): ([Vector<f64>; 3], [bool; 6]),
        span: Span,
    ) {
        if fixed == [false; 6] {
            return;
        }
        if !self.freedom.rotates(slave) {
            fixed[3..].fill(false);
        }
        if fixed == [false; 6] {
            return;
        }
        let relation = Relation::carried(self.position(slave), self.position(master), axes, fixed);
        let label = format!("{slave}-{master}");
        self.push(RelationElement { type_name, nodes: vec![slave, master], relation, label, span });
    }

    fn coupling(&mut self, coupling: &Coupling) -> Result<(), Diagnostic> {
        let nodes = self.scene.coupling_nodes(coupling);
        match &coupling.kind {
            CouplingKind::Kinematic(numbers) => {
                let fixed = [1, 2, 3, 4, 5, 6].map(|number| numbers.contains(&number));
                let orientation = coupling
                    .orientation
                    .as_ref()
                    .and_then(|name| Some((name, self.scene.orientations.get(&name.value)?)));
                for (slave, _) in nodes {
                    let axes = match orientation {
                        None => GLOBAL,
                        Some((name, orientation)) => {
                            let (slave, master) = (self.position(slave), self.position(coupling.reference));
                            let axes = orientation.triad(&name.value, self.scene, slave, &[master, slave])?;
                            if self.scene.two_dimensional {
                                plane::axes(self.scene, name, &axes)?;
                            }
                            axes
                        }
                    };
                    self.carried(
                        "KINEMATIC COUPLING",
                        [slave, coupling.reference],
                        (axes, fixed),
                        coupling.span,
                    );
                }
            }
            CouplingKind::Distributing(_) => {
                let shares: Vec<(f64, Vector<f64>)> =
                    nodes.iter().map(|(node, weight)| (*weight, self.position(*node))).collect();
                let relation = Relation::mean(self.position(coupling.reference), &shares);
                let members =
                    std::iter::once(coupling.reference).chain(nodes.into_iter().map(|(node, _)| node));
                self.push(RelationElement {
                    type_name: "DISTRIBUTING COUPLING",
                    nodes: members.collect(),
                    relation,
                    label: coupling.reference.to_string(),
                    span: coupling.span,
                });
            }
        }
        Ok(())
    }
}

/// The relations of a scene, in the order of the lists of a scene.
///
/// # Errors
/// Points of an `*ORIENTATION` or a `*TRANSFORM` that define no directions.
pub(super) fn relations(
    scene: &Scene,
    freedom: &NodeFreedom,
    mpcs: &[MpcElement],
) -> Result<Vec<RelationElement>, Diagnostic> {
    let hinges = mpcs.iter().flat_map(|mpc| mpc.nodes.iter().skip(2)).copied().collect();
    let mut builder = Builder { scene, freedom, hinges, found: Vec::new() };
    for equation in &scene.equations {
        let terms: Vec<(Label, u8, f64)> =
            equation.terms.iter().map(|term| (term.node, term.degree_of_freedom, term.factor)).collect();
        builder.linear("EQUATION", &terms, |node| scene.nodal_axes(node), equation.span)?;
    }
    for body in &scene.rigid_bodies {
        for (node, is_tied) in scene.body_nodes(body) {
            let tied = is_tied.unwrap_or_else(|| freedom.rotates(node));
            let fixed = [true, true, true, tied, tied, tied];
            builder.carried("RIGID BODY", [node, body.reference], (GLOBAL, fixed), body.span);
        }
    }
    for coupling in &scene.couplings {
        builder.coupling(coupling)?;
    }
    for tie in &scene.ties {
        for pair @ [slave, master] in scene.tied_nodes(tie) {
            for number in 1..=if scene.two_dimensional { 2 } else { 3 } {
                // Displacements are equal, whatever the axes that each node has them in.
                let terms = [(slave, number, 1.0), (master, number, -1.0)];
                builder.linear("TIE", &terms, |_| Ok(GLOBAL), tie.span)?;
            }
            if !tie.no_rotation && freedom.rotates(slave) && freedom.rotates(master) {
                let fixed = [false, false, false, true, true, true];
                builder.carried("TIE", pair, (GLOBAL, fixed), tie.span);
            }
        }
    }
    Ok(builder.found)
}
