//! Boundary conditions, motions, loads, steps and requests of output.

use crate::choice::Choice;
use crate::deck::history::NAMED;
use crate::deck::keywords;
use crate::deck::table::PER_LINE;
use crate::deck::write::{Deck, Name, has_control, plain, quoted, refuse, yes_no};
use crate::diagnostic::{Code, Result, suggest};
use crate::document::form;
use crate::document::form::{Boundary, Step};
use crate::label::normal;
use crate::model::{MotionType, Operation};
use crate::span::{Span, Spanned};

impl Deck {
    pub(super) fn velocities(&mut self, given: &[Spanned<form::InitialVelocity>]) -> Result<()> {
        for velocity in given {
            let (span, value) = (velocity.span, &velocity.value);
            self.keyword("INITIAL CONDITIONS", span);
            self.parameter("TYPE", "VELOCITY", span);
            self.go();
            self.begin(span);
            self.target(&value.target)?;
            self.item(&value.degree_of_freedom.value.to_string(), value.degree_of_freedom.span);
            self.number(value.magnitude.value, value.magnitude.span);
            self.end(false);
        }
        Ok(())
    }

    pub(super) fn actuation(
        &mut self,
        boundaries: &[Spanned<Boundary>],
        motions: &[Spanned<form::ConnectorMotion>],
    ) -> Result<()> {
        for boundary in boundaries {
            self.boundary(boundary)?;
        }
        for motion in motions {
            let span = motion.span;
            let value = &motion.value;
            self.keyword("CONNECTOR MOTION", span);
            self.motion_type(value.r#type, span);
            self.applied(value.amplitude.as_ref(), value.operation, value.load_case, span)?;
            self.flag("FIXED", value.fixed, span);
            self.flag("USER", value.user, span);
            self.flag("IMAGINARY", value.imaginary, span);
            self.go();
            self.begin(span);
            self.target(&value.target)?;
            self.item(&value.component.value.0.to_string(), value.component.span);
            if let Some(magnitude) = value.magnitude {
                self.number(magnitude.value, magnitude.span);
            }
            self.end(false);
        }
        Ok(())
    }

    fn motion_type(&mut self, kind: Option<MotionType>, span: Span) {
        self.word("TYPE", kind, span);
    }

    fn applied(
        &mut self,
        amplitude: Option<&Name>,
        operation: Option<Operation>,
        load_case: Option<Spanned<u64>>,
        span: Span,
    ) -> Result<()> {
        self.maybe_name("AMPLITUDE", amplitude)?;
        self.word("OP", operation, span);
        self.count_of("LOAD CASE", load_case);
        Ok(())
    }

    fn boundary(&mut self, boundary: &Spanned<Boundary>) -> Result<()> {
        let span = boundary.span;
        let value = &boundary.value;
        self.keyword("BOUNDARY", span);
        self.motion_type(value.r#type, span);
        self.applied(value.amplitude.as_ref(), value.operation, value.load_case, span)?;
        self.flag("FIXED", value.fixed, span);
        self.flag("USER", value.user, span);
        self.go();
        let held: Vec<u64> = value.degrees_of_freedom.iter().map(|freedom| freedom.value).collect();
        let Some(first) = value.degrees_of_freedom.first() else {
            let message = "a boundary condition without a degree of freedom".to_owned();
            let remedy = "list degrees of freedom, 1 to 6 or 10";
            return Err(refuse(Code::MissingData, span, message, "holds nothing", remedy));
        };
        let named = NAMED.iter().find(|(_, freedoms)| {
            freedoms.iter().map(|freedom| u64::from(*freedom)).eq(held.iter().copied())
        });
        let following = |a: u64, b: u64| b == a + 1 || (a, b) == (6, 10);
        let run = held.windows(2).all(|pair| matches!(pair, [a, b] if following(*a, *b)));
        let runs: Vec<&[Spanned<u64>]> = if run || (named.is_some() && value.magnitude.is_none()) {
            vec![value.degrees_of_freedom.as_slice()]
        } else {
            value.degrees_of_freedom.chunk_by(|a, b| following(a.value, b.value)).collect()
        };
        for freedoms in runs {
            self.begin(span);
            self.target(&value.target)?;
            match named.filter(|_| !run && value.magnitude.is_none()) {
                Some((name, _)) => self.item(name, first.span),
                None => {
                    for freedom in [freedoms.first(), freedoms.last()].into_iter().flatten() {
                        self.item(&freedom.value.to_string(), freedom.span);
                    }
                    if let Some(magnitude) = value.magnitude {
                        self.number(magnitude.value, magnitude.span);
                    }
                }
            }
            self.end(false);
        }
        Ok(())
    }

    pub(super) fn step(&mut self, step: &Spanned<Step>) -> Result<()> {
        let span = step.span;
        let value = &step.value;
        self.keyword("STEP", span);
        self.maybe_name("NAME", value.name.as_ref())?;
        if let Some(nlgeom) = value.nlgeom {
            self.parameter("NLGEOM", yes_no(nlgeom), span);
        }
        self.flag("PERTURBATION", value.perturbation, span);
        self.count_of("INC", value.increments);
        self.word("AMPLITUDE", value.default_amplitude, span);
        self.go();
        self.procedure(value, span)?;
        for kind in &value.removed {
            self.keyword(kind.value.spelling(), kind.span);
            self.word("OP", Some(Operation::New), kind.span);
            self.go();
        }
        self.actuation(&value.boundaries, &value.connector_motions)?;
        for load in &value.connector_loads {
            let (span, value) = (load.span, &load.value);
            self.keyword("CONNECTOR LOAD", span);
            self.applied(value.amplitude.as_ref(), value.operation, value.load_case, span)?;
            self.flag("IMAGINARY", value.imaginary, span);
            self.go();
            self.begin(span);
            self.target(&value.target)?;
            self.item(&value.component.value.0.to_string(), value.component.span);
            self.number(value.magnitude.value, value.magnitude.span);
            self.end(false);
        }
        for load in &value.concentrated_loads {
            let (span, value) = (load.span, &load.value);
            self.keyword("CLOAD", span);
            self.applied(value.amplitude.as_ref(), value.operation, value.load_case, span)?;
            self.flag("FOLLOWER", value.follower, span);
            self.flag("IMAGINARY", value.imaginary, span);
            self.go();
            self.begin(span);
            self.target(&value.target)?;
            self.item(&value.degree_of_freedom.value.to_string(), value.degree_of_freedom.span);
            self.number(value.magnitude.value, value.magnitude.span);
            self.end(false);
        }
        for load in &value.distributed_loads {
            let (span, value) = (load.span, &load.value);
            self.keyword("DLOAD", span);
            self.applied(value.amplitude.as_ref(), value.operation, value.load_case, span)?;
            self.flag("FOLLOWER", value.follower, span);
            self.flag("IMAGINARY", value.imaginary, span);
            self.go();
            self.begin(span);
            match &value.target {
                Some(target) => self.target(target)?,
                None => self.item("", span),
            }
            self.item(&quoted(&value.label)?, value.label.span);
            for item in &value.values {
                self.maybe(item.value.0, item.span);
            }
            self.end(true);
        }
        for request in &value.outputs {
            self.output(request)?;
        }
        self.keyword("END STEP", span);
        self.go();
        Ok(())
    }

    fn procedure(&mut self, step: &Step, span: Span) -> Result<()> {
        let times = step.times.as_ref();
        let Some(procedure) = &step.procedure else {
            return times.map_or(Ok(()), |times| {
                let message = "times of a step without a procedure".to_owned();
                let remedy = "give procedure = \"static\" or \"dynamic\"";
                Err(refuse(Code::MissingParameter, times.span, message, "not used", remedy))
            });
        };
        let name = normal(&procedure.value);
        match name.as_str() {
            "STATIC" | "DYNAMIC" => self.keyword(&name, procedure.span),
            "DYNAMIC_EXPLICIT" => {
                self.keyword("DYNAMIC", procedure.span);
                self.flag("EXPLICIT", true, procedure.span);
            }
            other if keywords::is_procedure(other) => {
                if let Some(times) = times {
                    let message = format!("the times of {other} are not kept");
                    return Err(refuse(Code::SurplusData, times.span, message, "not used", "remove them"));
                }
                self.keyword(other, procedure.span);
            }
            other => {
                let words = ["static", "dynamic", "dynamic_explicit"];
                let message = format!("there is no procedure `{}`", other.escape_debug());
                let remedy = suggest(&procedure.value, words, || {
                    "write static, dynamic or dynamic_explicit, or the keyword of another procedure"
                        .to_owned()
                });
                return Err(refuse(
                    Code::BadValue,
                    procedure.span,
                    message,
                    "not one of those allowed",
                    &remedy,
                ));
            }
        }
        self.go();
        if let Some(times) = times {
            let form::Times { initial, total, minimum, maximum } = &times.value;
            self.begin(times.span);
            for value in [initial, total, minimum, maximum] {
                let place = value.map_or(span, |value| value.span);
                self.maybe(value.map(|value| value.value), place);
            }
            self.end(true);
        }
        Ok(())
    }

    fn output(&mut self, request: &Spanned<form::OutputRequest>) -> Result<()> {
        let form::OutputRequest { keyword, element_set, node_set, parameters, variables } = &request.value;
        let name = normal(&keyword.value);
        if !keywords::is_output(&name) {
            let names: Vec<&str> = keywords::outputs().collect();
            let message = format!("`{}` is no output request", name.escape_debug());
            let remedy =
                suggest(&name, names.iter().copied(), || format!("write one of {}", names.join(", ")));
            return Err(refuse(Code::BadValue, keyword.span, message, "not one of those allowed", &remedy));
        }
        self.keyword(&name, request.span);
        for (name, value) in &parameters.0 {
            let key = plain(name, "the name of a parameter")?;
            match &value.value.0 {
                None => self.item(&key, name.span),
                Some(text) => {
                    let quotes = text.bytes().filter(|byte| *byte == b'"').count();
                    let outside = text.split('"').step_by(2).any(|part| part.contains(','));
                    if has_control(text) || quotes % 2 == 1 || outside {
                        let message = format!("`{}` cannot be the value of a parameter", text.escape_debug());
                        let remedy = "write no commas, quotation marks or line breaks";
                        return Err(refuse(
                            Code::BadParameterValue,
                            value.span,
                            message,
                            "not a value",
                            remedy,
                        ));
                    }
                    self.parameter(&key, text, value.span);
                }
            }
        }
        self.maybe_name("ELSET", element_set.as_ref())?;
        self.maybe_name("NSET", node_set.as_ref())?;
        self.go();
        for line in variables.chunks(PER_LINE) {
            self.begin(line.first().map_or(request.span, |variable| variable.span));
            for variable in line {
                self.item(&plain(variable, "an output variable")?, variable.span);
            }
            self.end(false);
        }
        Ok(())
    }
}
