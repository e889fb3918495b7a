//! The rates with which a run begins.

use crate::motion::rows::{Layout, Owner, Row};
use crate::motion::state::DOFS;
use crate::number::Number;
use crate::refusal::Refusal;
use crate::time::run::Run;

impl<R: Number> Run<'_, R> {
    /// The rates at the beginning: those given, and of all others the ones of least energy that fit the equations.
    pub(crate) fn launch(&mut self) -> Result<(), Refusal> {
        /// Of the size of a rate, what computing leaves.
        const ROUNDED: f64 = 1e-9;
        /// Of the largest rate, what writing leaves: seven digits are off by 5e-7 at most, in a velocity and in the turn that it must fit.
        const WRITTEN: f64 = 1e-6;
        if self.mechanism.velocities.is_empty() {
            return Ok(());
        }
        let mut found = self.assembled(&self.modes).map_err(|trouble| self.say(trouble))?;
        let zero = R::ZERO;
        for (given, (node, k, amount)) in self.mechanism.velocities.iter().enumerate() {
            let coefficients = found.lines.add([(DOFS * node + k, R::integer(1))]);
            let now = self.state.rates[*node][*k];
            found.rows.push(Row {
                owner: Owner::Given(given),
                force: None,
                coefficients,
                residual: None,
                rate: Some(now - *amount),
                bias: zero,
                driven: zero,
            });
        }
        let layout = Layout::new(&self.mechanism, &found, &self.modes)?;
        let (change, _) = found.correction(&layout, |row| row.rate).map_err(|trouble| self.say(trouble))?;
        let fastest = self.fastest_given();
        let rates = found.rows.iter().filter_map(|row| row.rate);
        let most = rates.fold(0.0, |most: f64, rate| most.max(rate.to_f64().abs()));
        let mut misfit: f64 = 0.0;
        for row in &found.rows {
            let entries = found.lines.of(row.coefficients).iter();
            let moved = entries.fold(zero, |sum, (dof, entry)| sum + *entry * change[*dof]);
            let gap = (row.rate.unwrap_or(zero) + moved).to_f64().abs();
            // Rounding alone leaves a part of the largest.
            let size = row.rate.map_or(0.0, |rate| rate.to_f64().abs()).max(moved.to_f64().abs());
            if row.rate.is_none() || gap <= ROUNDED * size.max(1e-3 * most) {
                continue;
            }
            misfit = misfit.max(gap / self.size_of(row.owner).to_f64() / fastest);
            if misfit > WRITTEN {
                return Err(Refusal::of(
                    &self.mechanism.named(row.owner),
                    "the velocities given at the beginning do not fit the constraints",
                    "give those of one node of each rigid body, or make them agree",
                ));
            }
        }
        for (dof, by) in change.iter().enumerate() {
            let rate = &mut self.state.rates[dof / DOFS][dof % DOFS];
            *rate = *rate + *by;
        }
        self.bring();
        if misfit > 0.0 { self.fit_launch() } else { Ok(()) }
    }

    /// Brings the rates given to the equations that they miss by the rounding of a deck, by the least change in energy.
    fn fit_launch(&mut self) -> Result<(), Refusal> {
        for (node, k, amount) in &self.mechanism.velocities {
            self.state.rates[*node][*k] = *amount;
        }
        self.bring();
        self.project()?;
        let fastest = self.fastest_given();
        let change = |(node, k, amount): &(usize, usize, R)| {
            let by = (self.state.rates[*node][*k] - *amount).to_f64().abs();
            by / self.unit_of(*k) / fastest
        };
        self.solution.changed = self.mechanism.velocities.iter().map(change).fold(0.0, f64::max);
        Ok(())
    }

    /// The largest rate that is given: lengths by the size of the model.
    fn fastest_given(&self) -> f64 {
        let given = self.mechanism.velocities.iter();
        let sizes = given.map(|(_, k, amount)| amount.to_f64().abs() / self.unit_of(*k));
        sizes.fold(f64::MIN_POSITIVE, f64::max)
    }

    fn unit_of(&self, k: usize) -> f64 {
        if k < 3 { self.mechanism.length } else { 1.0 }
    }

    /// Rates of another trial begin with another rounding: all trials would share that of the first ones.
    pub(crate) fn round_otherwise(&mut self) -> Result<(), Refusal> {
        // What rests relative to another body may stick to it, or be in touch: that must not end.
        let mechanism = &self.mechanism;
        let is_smooth =
            mechanism.sliders.is_empty() && mechanism.stops.is_empty() && mechanism.criteria.is_empty();
        if self.options.trial == 0 || !is_smooth {
            return Ok(());
        }
        let places = self.state.rates.iter_mut().flatten().enumerate();
        for (place, rate) in places {
            let sign = if place.is_multiple_of(usize::from(self.options.trial) + 1) { 1.0 } else { -1.0 };
            *rate = *rate + *rate * R::from_f64(sign * 2.0 * R::ROUNDING);
        }
        self.bring();
        self.project()
    }
}
