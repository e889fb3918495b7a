//! Energies of a static path: the work of forces along it.
//!
//! Between two equilibria each force does the work of its mean along the way from one to the other. That sum is symmetrical, so that its error
//! has even powers of the way alone, and what halving leaves is extrapolated (Romberg).

use crate::motion::mode::Does;
use crate::motion::rows::{Instant, Trouble};
use crate::motion::state::{DOFS, Pose, State, WORKS};
use crate::number::{Number, largest};
use crate::refusal::Refusal;
use crate::time::run::Run;
use crate::time::still::Found;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{product, sub, transpose};

/// The most halvings of a step.
const HALVINGS: usize = 6;

/// A way from one pose to another, as rates that take one unit of time.
pub(crate) fn way<R: Number>(from: &Pose<R>, to: &Pose<R>) -> [R; DOFS] {
    let moved = sub(to.displacement, from.displacement);
    let turned = so3::log(&product(&to.rotation, &transpose(&from.rotation)));
    let [x, y, z] = moved;
    let [p, q, r] = turned;
    [x, y, z, p, q, r, to.flow - from.flow]
}

impl<R: Number> Run<'_, R> {
    /// Goes on to an equilibrium, and counts the work on the way.
    pub(crate) fn advance(&mut self, found: Found<R>) -> Result<(), Refusal> {
        let works = match &found.curve {
            Some(curve) => curve.works,
            None => self.works_to(&found)?,
        };
        self.state = found.state;
        for slip in found.curve.into_iter().flat_map(|curve| curve.slips) {
            self.modes.frictions[slip.of].does = Does::Slips(slip.along[1]);
        }
        for (sum, work) in self.state.sums.iter_mut().zip(works) {
            *sum = *sum + work;
        }
        Ok(())
    }

    /// External work, dissipation and stored energy on the way to an equilibrium.
    fn works_to(&mut self, last: &Found<R>) -> Result<[R; WORKS], Refusal> {
        let zero = R::ZERO;
        let (start, end) = (self.state.time, last.state.time);
        if !start.less(end) {
            return Ok([zero; WORKS]);
        }
        let steps = self.solution.steps;
        let first = self.balance(start)?;
        let tolerance = R::from_f64(10.0_f64.powi(-(self.options.digits as i32)));
        let mut known: Vec<Found<R>> = vec![first, last.clone()];
        let mut table: Vec<[R; WORKS]> = Vec::new();
        for halving in 0..=HALVINGS {
            if halving > 0 {
                let parts = R::integer(2 * (known.len() as i32 - 1));
                let mut finer = Vec::with_capacity(2 * known.len());
                for (i, found) in std::mem::take(&mut known).into_iter().enumerate() {
                    if i > 0 {
                        let part = R::integer(2 * i as i32 - 1) / parts;
                        finer.push(self.balance(start + (end - start) * part)?);
                    }
                    finer.push(found);
                }
                known = finer;
            }
            let mut row = [zero; WORKS];
            for pair in known.windows(2) {
                let part = self.between(&pair[0], &pair[1]).map_err(|trouble| self.say(trouble))?;
                row.iter_mut().zip(part).for_each(|(sum, part)| *sum = *sum + part);
            }
            let mut power = 1;
            let mut change = zero;
            for before in &mut table {
                power *= 4;
                let mut next = row;
                for (next, old) in next.iter_mut().zip(before.iter()) {
                    *next = *next + (*next - *old) / R::integer(power - 1);
                }
                change = largest(next.iter().zip(before.iter()).map(|(new, old)| *new - *old));
                *before = std::mem::replace(&mut row, next);
            }
            table.push(row);
            let size = largest(row.iter().chain(&self.state.sums[..WORKS]).copied());
            if halving > 0 && !(tolerance * size).less(change) {
                break;
            }
        }
        self.solution.steps = steps;
        Ok(table.pop().unwrap_or([zero; WORKS]))
    }

    /// The means of forces at both ends, times the way.
    fn between(&self, from: &Found<R>, to: &Found<R>) -> Result<[R; WORKS], Trouble> {
        let way: Vec<[R; DOFS]> =
            from.state.poses.iter().zip(&to.state.poses).map(|(from, to)| way(from, to)).collect();
        let half = R::ratio(1, 2);
        let [one, two] = [from, to].map(|end| self.powers(end, &way));
        let (one, two) = (one?, two?);
        Ok(std::array::from_fn(|i| (one[i] + two[i]) * half))
    }

    /// The powers of loads and of what is prescribed, of friction, and into springs, if nodes had these rates.
    pub(crate) fn powers(&self, at: &Found<R>, rates: &[[R; DOFS]]) -> Result<[R; WORKS], Trouble> {
        let zero = R::ZERO;
        let still = vec![[zero; 3]; rates.len()];
        let state = State { rates: rates.to_vec(), ..at.state.clone() };
        let instant = Instant::of(&state, self.step, &still);
        let found = self.mechanism.assemble(&instant, &self.modes, &self.beginnings)?;
        let [mut external, _, stored] = found.powers;
        for (force, index) in at.solved.forces.iter().zip(&self.layout.kept) {
            let along = found
                .lines
                .of(self.layout.force(*index, &found.rows[*index]))
                .iter()
                .fold(zero, |sum, (dof, entry)| sum + *entry * rates[dof / DOFS][dof % DOFS]);
            external = external - *force * along;
        }
        let mut dissipated = zero;
        for (now, friction) in found.joints.iter().zip(&at.solved.friction) {
            for k in 0..6 {
                dissipated = dissipated + friction[k] * now.velocity[k];
            }
        }
        Ok([external, dissipated, stored])
    }
}
