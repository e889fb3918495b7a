//! Equations, surfaces, rigid bodies, couplings and ties.

use crate::deck::write::{Deck, refuse};
use crate::diagnostic::{Code, Result};
use crate::document::form;
use crate::document::form::Document;
use crate::span::Spanned;

/// Terms of an equation on one line.
const TERMS_PER_LINE: usize = 4;

impl Deck {
    pub(super) fn constraints(&mut self, document: &Document) -> Result<()> {
        for equation in &document.equations {
            self.equation(equation)?;
        }
        for (name, members) in &document.surfaces.0 {
            self.keyword("SURFACE", name.span);
            self.name("NAME", name)?;
            self.parameter("TYPE", "NODE", name.span);
            self.go();
            for member in members {
                self.begin(member.span);
                self.target(&member.value.node)?;
                if let Some(area) = member.value.area {
                    self.number(area.value, area.span);
                }
                self.end(false);
            }
        }
        for (place, body) in document.rigid_bodies.iter().enumerate() {
            let form::RigidBody { reference, element_set, pin_set, tie_set, .. } = &body.value;
            let own = self.nodes_of((place, body), document)?;
            let tie_set = own.as_ref().or(tie_set.as_ref());
            self.keyword("RIGID BODY", body.span);
            self.node_parameter("REF NODE", reference)?;
            self.maybe_name("ELSET", element_set.as_ref())?;
            self.maybe_name("PIN NSET", pin_set.as_ref())?;
            self.maybe_name("TIE NSET", tie_set)?;
            self.go();
        }
        for coupling in &document.couplings {
            self.coupling(coupling)?;
        }
        for tie in &document.ties {
            let form::Tie { name, slave, master, position_tolerance, no_rotation } = &tie.value;
            self.keyword("TIE", tie.span);
            if !name.value.is_empty() {
                self.name("NAME", name)?;
            }
            self.number_of("POSITION TOLERANCE", *position_tolerance);
            self.flag("NO ROTATION", *no_rotation, tie.span);
            self.go();
            self.begin(slave.span);
            self.item(&super::quoted(slave)?, slave.span);
            self.item(&super::quoted(master)?, master.span);
            self.end(false);
        }
        Ok(())
    }

    /// A set of the nodes that a rigid body names one by one, with those of its set.
    fn nodes_of(
        &mut self,
        (place, body): (usize, &Spanned<form::RigidBody>),
        document: &Document,
    ) -> Result<Option<Spanned<String>>> {
        let nodes = &body.value.nodes;
        if nodes.is_empty() {
            return Ok(None);
        }
        let mut name = format!("NODES-OF-RIGID-BODY-{}", place + 1);
        while document.node_sets.0.iter().any(|(known, _)| known.value.eq_ignore_ascii_case(&name)) {
            name.push('-');
        }
        self.keyword("NSET", body.span);
        self.parameter("NSET", &name, body.span);
        self.go();
        for node in nodes {
            self.begin(node.span);
            self.target(node)?;
            self.end(false);
        }
        if let Some(set) = &body.value.tie_set {
            self.begin(set.span);
            self.item(&super::quoted(set)?, set.span);
            self.end(false);
        }
        Ok(Some(Spanned::new(name, body.span)))
    }

    /// A parameter that names a node.
    fn node_parameter(&mut self, parameter: &str, node: &Spanned<form::Target>) -> Result<()> {
        let text = match &node.value {
            form::Target::Number(number) => number.to_string(),
            form::Target::Text(text) => super::label_or_name(text, node.span)?,
        };
        self.parameter(parameter, text, node.span);
        Ok(())
    }

    fn equation(&mut self, equation: &Spanned<form::Equation>) -> Result<()> {
        let terms = &equation.value.terms;
        self.keyword("EQUATION", equation.span);
        self.go();
        self.begin(equation.span);
        self.item(&terms.len().to_string(), equation.span);
        self.end(false);
        for line in terms.chunks(TERMS_PER_LINE) {
            self.begin(line.first().map_or(equation.span, |term| term.span));
            for Spanned { value: form::EquationTerm { node, degree_of_freedom, factor }, .. } in line {
                self.target(node)?;
                self.item(&degree_of_freedom.value.to_string(), degree_of_freedom.span);
                self.number(factor.value, factor.span);
            }
            self.end(false);
        }
        Ok(())
    }

    fn coupling(&mut self, coupling: &Spanned<form::Coupling>) -> Result<()> {
        let span = coupling.span;
        let form::Coupling {
            name,
            reference,
            surface,
            orientation,
            influence_radius,
            kinematic,
            distributing,
        } = &coupling.value;
        if kinematic.is_empty() == distributing.is_none() {
            let message = format!("coupling {} is to be kinematic or distributing", name.value);
            let remedy = "write kinematic = [degrees of freedom], or distributing = \"uniform\"";
            return Err(refuse(Code::BadValue, span, message, "one of the two", remedy));
        }
        self.keyword("COUPLING", span);
        if !name.value.is_empty() {
            self.name("CONSTRAINT NAME", name)?;
        }
        self.node_parameter("REF NODE", reference)?;
        self.name("SURFACE", surface)?;
        self.maybe_name("ORIENTATION", orientation.as_ref())?;
        self.number_of("INFLUENCE RADIUS", *influence_radius);
        self.go();
        self.keyword(if distributing.is_some() { "DISTRIBUTING" } else { "KINEMATIC" }, span);
        self.word("WEIGHTING METHOD", *distributing, span);
        self.go();
        for number in kinematic {
            self.begin(number.span);
            self.item(&number.value.to_string(), number.span);
            self.end(false);
        }
        Ok(())
    }
}
