//! Sections, constraints, point elements and amplitudes.

use crate::deck::table::PER_LINE;
use crate::deck::write::{Deck, NODES_PER_LINE, Name, dependencies, plain, quoted, refuse, yes_no};
use crate::diagnostic::{Code, Result};
use crate::document::form;
use crate::document::form::Document;
use crate::span::Spanned;

impl Deck {
    pub(super) fn properties(&mut self, document: &Document) -> Result<()> {
        for section in &document.connector_sections {
            self.section(section)?;
        }
        for mpc in &document.mpcs {
            let form::Mpc { r#type, nodes, user } = &mpc.value;
            self.keyword("MPC", mpc.span);
            self.flag("USER", *user, mpc.span);
            self.go();
            self.begin(mpc.span);
            self.item(&plain(r#type, "a type of constraints")?, r#type.span);
            for (place, node) in nodes.iter().enumerate() {
                if place > 0 && place % NODES_PER_LINE == 0 && !user {
                    self.end(false);
                    self.begin(node.span);
                    self.item("0", node.span);
                }
                self.target(node)?;
            }
            self.end(false);
        }
        self.constraints(document)?;
        for mass in &document.masses {
            self.keyword("MASS", mass.span);
            self.name("ELSET", &mass.value.element_set)?;
            self.go();
            self.begin(mass.value.mass.span);
            self.number(mass.value.mass.value, mass.value.mass.span);
            self.end(false);
        }
        for inertia in &document.rotary_inertias {
            self.keyword("ROTARY INERTIA", inertia.span);
            self.name("ELSET", &inertia.value.element_set)?;
            self.maybe_name("ORIENTATION", inertia.value.orientation.as_ref())?;
            self.go();
            self.begin(inertia.value.inertia.span);
            self.numbers(&inertia.value.inertia.value, inertia.value.inertia.span);
            self.end(false);
        }
        for (keyword, list) in [("SPRING", &document.springs), ("DASHPOT", &document.dashpots)] {
            for discrete in list {
                self.discrete(keyword, discrete)?;
            }
        }
        Ok(())
    }

    fn discrete(&mut self, keyword: &str, discrete: &Spanned<form::Discrete>) -> Result<()> {
        let span = discrete.span;
        let value = &discrete.value;
        let width = 3 + dependencies(value.dependencies);
        self.keyword(keyword, span);
        self.name("ELSET", &value.element_set)?;
        self.flag("NONLINEAR", value.nonlinear, span);
        self.maybe_name("ORIENTATION", value.orientation.as_ref())?;
        self.flag("COMPLEX STIFFNESS", value.complex, span);
        self.count_of("DEPENDENCIES", value.dependencies);
        self.go();
        self.begin(value.degrees_of_freedom.first().map_or(span, |freedom| freedom.span));
        for freedom in &value.degrees_of_freedom {
            self.item(&freedom.value.to_string(), freedom.span);
        }
        self.end(false);
        self.raws(&value.rows, width);
        Ok(())
    }

    fn section(&mut self, section: &Spanned<form::ConnectorSection>) -> Result<()> {
        let span = section.span;
        let form::ConnectorSection {
            element_set,
            r#type,
            behavior,
            orientation_a,
            orientation_b,
            data,
            controls,
            elimination,
        } = &section.value;
        self.keyword("CONNECTOR SECTION", span);
        self.name("ELSET", element_set)?;
        self.maybe_name("BEHAVIOR", behavior.as_ref())?;
        self.maybe_name("CONTROLS", controls.as_ref())?;
        if let Some(elimination) = elimination {
            self.parameter("ELIMINATION", yes_no(*elimination), span);
        }
        self.go();
        self.begin(span);
        for name in &r#type.0 {
            self.item(&plain(name, "a connection type")?, name.span);
        }
        self.end(false);
        if orientation_a.is_some() || orientation_b.is_some() || !data.is_empty() {
            self.begin(span);
            for (place, orientation) in [orientation_a, orientation_b].into_iter().enumerate() {
                match orientation {
                    Some(name) => self.item(&quoted(name)?, name.span),
                    None if place == 0 && orientation_b.is_some() => self.item("", span),
                    None => {}
                }
            }
            self.end(false);
        }
        if !data.is_empty() {
            self.begin(span);
            for item in data {
                self.maybe(item.value.0, item.span);
            }
            self.end(true);
        }
        Ok(())
    }

    pub(super) fn amplitude(&mut self, name: &Name, amplitude: &Spanned<form::Amplitude>) -> Result<()> {
        let span = name.span;
        let form::Amplitude { definition, time, value, smooth, fixed_interval, begin, pairs, data } =
            &amplitude.value;
        self.keyword("AMPLITUDE", span);
        self.name("NAME", name)?;
        self.word("DEFINITION", *definition, span);
        self.word("TIME", *time, span);
        self.word("VALUE", *value, span);
        self.number_of("SMOOTH", *smooth);
        self.number_of("FIXED INTERVAL", *fixed_interval);
        self.number_of("BEGIN", *begin);
        self.go();
        let takes_pairs = definition.is_none_or(|definition| definition.has_pairs());
        if let Some(item) = data.first().filter(|_| takes_pairs) {
            let message = format!("amplitude {} takes pairs of time and value", name.value);
            let remedy = "write pairs = [[time, value], …]";
            return Err(refuse(Code::BadValue, item.span, message, "not pairs", remedy));
        }
        if let Some(pair) = pairs.first().filter(|_| !takes_pairs) {
            let message = format!("amplitude {} takes no pairs", name.value);
            return Err(refuse(Code::BadValue, pair.span, message, "not used", "write data = [numbers]"));
        }
        let pairs = pairs.iter().flat_map(|pair| pair.value).map(|number| (Some(number.value), number.span));
        let data = data.iter().map(|item| (item.value.0, item.span));
        let items: Vec<_> = pairs.chain(data).collect();
        for line in items.chunks(PER_LINE) {
            self.begin(line.first().map_or(span, |(_, span)| *span));
            for (value, span) in line {
                self.maybe(*value, *span);
            }
            self.end(line.last().is_some_and(|(value, _)| value.is_none()));
        }
        Ok(())
    }
}
