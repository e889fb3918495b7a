//! Second derivatives of many states: as matrices, and in the two products that solvers need.
//!
//! The loops give derivatives by the relative variations; all else is made of them here, once for all formulas. The products form no
//! matrix of a row.

use crate::batch::kernel::{Slices, loops};
use crate::batch::layout::{Derivatives, Fused, HessianRow, RelativeRow, Shape, with_constant};
use crate::batch::rows::{Array, Moves, States, TILES, on_unit};
use crate::batch::tile::Four;
use crate::batch::unit::Unit;
use crate::batch::{Batch, BatchError, History, Layout, Section, Tile, same_length};
use crate::scalar::lanes::{LANES, Lanes};
use crate::vector::{Vector, add, apply, apply_transposed, cross, dot, sub, times};
use pulp::{Simd, WithSimd};
use std::cell::Cell;
use std::ops::Range;

/// Twelve numbers of four states by columns: x_a, θ_a, x_b, θ_b.
pub type Columns12 = [Four; 12];

/// Rows that are found before anything is made of them: they stay in the first cache.
const AT_ONCE: usize = 24;

thread_local! {
    /// Room for rows, which calls share.
    static ROOM: Cell<Vec<RelativeRow>> = const { Cell::new(Vec::new()) };
}

/// What is made of rows.
trait Made {
    /// Of tile number `at`.
    fn of_tile(&mut self, at: usize, separation: Vector<Fused>, rows: &[RelativeRow], shapes: &[Shape]);
}

struct Making<'l, M> {
    first: usize,
    tiles: &'l [Tile],
    found: &'l [RelativeRow],
    shapes: &'l [Shape],
    made: &'l mut M,
}

impl<M: Made> WithSimd for Making<'_, M> {
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn with_simd<V: Simd>(self, _: V) {
        let Self { first, tiles, found, shapes, made } = self;
        for i in 0..tiles.len() {
            let rows = found.get(i * shapes.len()..(i + 1) * shapes.len());
            let (Some(tile), Some(rows)) = (tiles.get(i), rows) else { return };
            made.of_tile(first + i, tile.pair().separation(), rows, shapes);
        }
    }
}

impl Batch {
    /// The rows of some tiles at a time, and what is made of them.
    fn make(&self, of: Slices<'_>, made: &mut impl Made) {
        let (each, count, shapes) = (self.rows(), of.tiles.len(), self.shapes.as_slice());
        let Some(at_once) = AT_ONCE.checked_div(each) else { return };
        let mut room = ROOM.take();
        let needed = each * at_once.min(count);
        if room.len() < needed {
            room.resize(needed, RelativeRow::default());
        }
        for first in (0..count).step_by(at_once) {
            let these = first..count.min(first + at_once);
            let found = room.get_mut(..these.len() * each);
            let (Some(found), Some(slices)) = (found, of.part(these)) else { break };
            loops(self, slices, found);
            self.arch.dispatch(Making { first, tiles: slices.tiles, found, shapes, made });
        }
        ROOM.set(room);
    }

    /// The rate of each row along a motion whose velocities are constant, J̇v = ∂²c[v, v]: what is left of c̈ without accelerations.
    ///
    /// - `velocities`: of each tile ẋ_a, ω_a, ẋ_b, ω_b (length/time, rad/time), global components
    /// - `out`: of each tile one number for each of [`Batch::rows`], (length or rad)/time²
    ///
    /// # Errors
    /// [`BatchError::Length`] for slices of another length.
    pub fn bias_of(
        &self,
        tiles: &[Tile],
        sections: &[Section],
        histories: &[History],
        velocities: &[Columns12],
        out: &mut [Four],
    ) -> Result<(), BatchError> {
        let slices = self.slices(tiles, sections, histories)?;
        same_length("velocities", velocities.len(), tiles.len())?;
        same_length("numbers", out.len(), tiles.len() * self.rows())?;
        self.make(slices, &mut Bias { velocities, each: self.rows(), out });
        Ok(())
    }

    /// The geometric stiffness Σ_k λ_k ∂²c_k, symmetric to rounding, by x_a, θ_a, x_b, θ_b along x and exp(δθ^) C.
    ///
    /// - `multipliers`: of each tile λ for each of [`Batch::rows`] (force for lengths, moment for angles)
    /// - `out`: of each tile twelve rows of twelve columns
    ///
    /// # Errors
    /// [`BatchError::Length`] for slices of another length.
    pub fn geometric_stiffness_of(
        &self,
        tiles: &[Tile],
        sections: &[Section],
        histories: &[History],
        multipliers: &[Four],
        out: &mut [[Columns12; 12]],
    ) -> Result<(), BatchError> {
        let slices = self.slices(tiles, sections, histories)?;
        same_length("multipliers", multipliers.len(), tiles.len() * self.rows())?;
        same_length("matrices", out.len(), tiles.len())?;
        if self.rows() == 0 {
            out.fill([[[0.0; LANES]; 12]; 12]);
        }
        self.make(slices, &mut Stiffness { multipliers, each: self.rows(), out });
        Ok(())
    }
}

impl Batch {
    /// The geometric stiffness along a variation, (Σ_k λ_k ∂²c_k) v, without the matrix. It is half the gradient of Σ_k λ_k ∂²c_k[v, v], and
    /// so the change of Σ_k λ_k ∂c_k along v at constant λ. Rotations vary as in [`Pair::nodal_hessian`](crate::node::Pair::nodal_hessian).
    ///
    /// - `multipliers`: as of [`Batch::geometric_stiffness_of`]
    /// - `along`: of each tile v by x_a, θ_a, x_b, θ_b (length, rad), global components
    /// - `out`: of each tile the changes by x_a, θ_a, x_b, θ_b (force, moment)
    ///
    /// # Errors
    /// [`BatchError::Length`] for slices of another length.
    pub fn geometric_stiffness_along(
        &self,
        slices: (&[Tile], &[Section], &[History]),
        multipliers: &[Four],
        along: &[Columns12],
        out: &mut [Columns12],
    ) -> Result<(), BatchError> {
        let (tiles, sections, histories) = slices;
        let slices = self.slices(tiles, sections, histories)?;
        same_length("multipliers", multipliers.len(), tiles.len() * self.rows())?;
        same_length("variations", along.len(), tiles.len())?;
        same_length("changes of forces", out.len(), tiles.len())?;
        out.fill([[0.0; LANES]; 12]);
        self.make(slices, &mut Along { multipliers, along, each: self.rows(), out });
        Ok(())
    }
}

/// The velocities of a node in many states.
#[derive(Clone, Copy, Debug)]
pub struct Velocities<'a> {
    /// ẋ (length/time), three numbers.
    pub velocity: Array<'a>,
    /// ω (rad/time), global components, three numbers.
    pub angular_velocity: Array<'a>,
}

impl Batch {
    /// J̇v of many states, into memory of the caller: [`Batch::bias_of`] from arrays in C order.
    ///
    /// - `velocities`: those of a and of b
    /// - `out` (count, [`Batch::rows`]): (length or rad)/time²
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let thread = std::thread::Builder::new().stack_size(256 << 20);
    /// # Ok(thread.spawn(|| example().map_err(|error| error.to_string()))?.join().expect("no panic")?)
    /// # }
    /// # fn example() -> Result<(), Box<dyn std::error::Error>> {
    /// use pintle_kinematics::batch::{Array, Batch, History, Nodes, Orientation, Section, States, Velocities};
    /// use pintle_kinematics::catalog::ConnectionType;
    /// use pintle_kinematics::connector::{Connector, Definition};
    /// use pintle_kinematics::node::{Node, Pair};
    /// use pintle_kinematics::vector::identity;
    ///
    /// // A LINK of length 5 whose end b moves at right angles to it, with velocity 2: v²/l.
    /// let still = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
    /// let initial = Pair { reference: [3.0, 4.0, 0.0], a: still, b: still };
    /// let connector = Connector::new(&Definition::new(ConnectionType::named("LINK", None)?, initial));
    /// let batch = Batch::new(&connector, [true; 6])?;
    /// let (zero, triad) = ([0.0; 3], [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    /// let node = Nodes {
    ///     displacement: Array::shared(&zero),
    ///     orientation: Orientation::Triad(Array::shared(&triad)),
    /// };
    /// let states = States {
    ///     count: 1,
    ///     reference: Array::shared(&initial.reference),
    ///     nodes: [node; 2],
    ///     sections: &[Section::new(&[&connector; 4])],
    ///     histories: &[History::new(&[connector.initial_branch(); 4])],
    /// };
    /// let (resting, moving) = (Array::shared(&zero), [0.0, 0.0, 2.0]);
    /// let a = Velocities { velocity: resting, angular_velocity: resting };
    /// let b = Velocities { velocity: Array::shared(&moving), angular_velocity: resting };
    /// let mut bias = [0.0];
    /// batch.bias_of_states(&states, [a, b], &mut bias)?;
    /// assert!((bias[0] - 0.8).abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`BatchError::Length`] where an array is too short, or `out` has another length.
    pub fn bias_of_states(
        &self,
        states: &States<'_>,
        velocities: [Velocities<'_>; 2],
        out: &mut [f64],
    ) -> Result<(), BatchError> {
        let (count, each) = (states.count, self.rows());
        states.check()?;
        for of in velocities {
            of.velocity.check("velocities", count, 3)?;
            of.angular_velocity.check("angular velocities", count, 3)?;
        }
        same_length("numbers", out.len(), count.saturating_mul(each))?;
        let arrays = velocities.map(|of| [of.velocity, of.angular_velocity]);
        let mut rates = [[[0.0; LANES]; 12]; TILES];
        let mut found = vec![[0.0; LANES]; TILES * each];
        self.in_blocks(states, |these, slices| {
            of_nodes(&arrays, &these, &mut rates);
            self.make(slices, &mut Bias { velocities: &rates, each, out: &mut found });
            let out = out.get_mut(these.start * each..these.end * each).unwrap_or_default();
            for (state, to) in out.chunks_exact_mut(each).enumerate() {
                let of = found.iter().skip(state / LANES * each);
                to.iter_mut().zip(of).for_each(|(to, of)| *to = of[state % LANES]);
            }
        });
        Ok(())
    }

    /// Σ_k λ_k ∂²c_k of many states, into memory of the caller: [`Batch::geometric_stiffness_of`] from arrays in C order.
    ///
    /// - `multipliers` (count, [`Batch::rows`]): λ (force for lengths, moment for angles)
    /// - `out` (count, 12, 12): rows and columns x_a, θ_a, x_b, θ_b
    ///
    /// # Errors
    /// [`BatchError::Length`] where an array is too short, or `multipliers` or `out` has another length.
    pub fn geometric_stiffness_of_states(
        &self,
        states: &States<'_>,
        multipliers: &[f64],
        out: &mut [f64],
    ) -> Result<(), BatchError> {
        let (count, each) = (states.count, self.rows());
        states.check()?;
        same_length("multipliers", multipliers.len(), count.saturating_mul(each))?;
        same_length("numbers of matrices", out.len(), count.saturating_mul(144))?;
        if each == 0 {
            out.fill(0.0);
        }
        let mut own = vec![[0.0; LANES]; TILES * each];
        let mut found = [[[[0.0; LANES]; 12]; 12]; TILES];
        self.in_blocks(states, |these, slices| {
            of_rows((multipliers, each), &these, &mut own);
            self.make(slices, &mut Stiffness { multipliers: &own, each, out: &mut found });
            let out = out.get_mut(these.start * 144..these.end * 144).unwrap_or_default();
            on_unit(self.arch, SpreadMatrices { found: &found, out: out.as_chunks_mut().0 });
        });
        Ok(())
    }
}

impl Batch {
    /// (Σ_k λ_k ∂²c_k) v of many states, into memory of the caller: [`Batch::geometric_stiffness_along`] from arrays in C order.
    ///
    /// - `multipliers` (count, [`Batch::rows`]): λ (force for lengths, moment for angles)
    /// - `along`: v of a and of b, as velocities (length, rad)
    /// - `out` (count, 12): by x_a, θ_a, x_b, θ_b
    ///
    /// # Errors
    /// [`BatchError::Length`] where an array is too short, or `multipliers` or `out` has another length.
    pub fn geometric_stiffness_along_of_states(
        &self,
        states: &States<'_>,
        multipliers: &[f64],
        along: [Velocities<'_>; 2],
        out: &mut [f64],
    ) -> Result<(), BatchError> {
        let (count, each) = (states.count, self.rows());
        states.check()?;
        for of in along {
            of.velocity.check("variations", count, 3)?;
            of.angular_velocity.check("variations", count, 3)?;
        }
        same_length("multipliers", multipliers.len(), count.saturating_mul(each))?;
        same_length("changes of forces", out.len(), count.saturating_mul(12))?;
        if each == 0 {
            out.fill(0.0);
        }
        let arrays = along.map(|of| [of.velocity, of.angular_velocity]);
        let mut own = vec![[0.0; LANES]; TILES * each];
        let [mut variations, mut found] = [[[[0.0; LANES]; 12]; TILES]; 2];
        self.in_blocks(states, |these, slices| {
            of_nodes(&arrays, &these, &mut variations);
            of_rows((multipliers, each), &these, &mut own);
            found.fill([[0.0; LANES]; 12]);
            self.make(slices, &mut Along { multipliers: &own, along: &variations, each, out: &mut found });
            let out = out.get_mut(these.start * 12..these.end * 12).unwrap_or_default();
            for (state, to) in out.chunks_exact_mut(12).enumerate() {
                let of = &found[state / LANES];
                to.iter_mut().zip(of).for_each(|(to, of)| *to = of[state % LANES]);
            }
        });
        Ok(())
    }
}

/// Twelve numbers of each of those states, by tiles, from arrays of three: the last state stands for those that a tile lacks.
fn of_nodes(arrays: &[[Array<'_>; 2]; 2], these: &Range<usize>, out: &mut [Columns12; TILES]) {
    for (tile, out) in out.iter_mut().take(these.len().div_ceil(LANES)).enumerate() {
        for lane in 0..LANES {
            let state = (these.start + LANES * tile + lane).min(these.end - 1);
            for (three, array) in arrays.as_flattened().iter().enumerate() {
                let of = array.at(state).copied().unwrap_or([f64::NAN; 3]);
                (0..3).for_each(|i| out[3 * three + i][lane] = of[i]);
            }
        }
    }
}

/// A number of each row of those states, by tiles.
fn of_rows((numbers, each): (&[f64], usize), these: &Range<usize>, out: &mut [Four]) {
    for (at, out) in out.iter_mut().enumerate() {
        let (tile, row) = (at / each, at % each);
        let state = |lane: usize| (these.start + LANES * tile + lane).min(these.end - 1);
        *out = [0, 1, 2, 3].map(|lane| numbers.get(state(lane) * each + row).copied().unwrap_or(f64::NAN));
    }
}

/// Matrices of tiles, state by state.
struct SpreadMatrices<'l> {
    found: &'l [[Columns12; 12]],
    out: &'l mut [[f64; 144]],
}

impl Moves for SpreadMatrices<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn on<U: Unit>(self, unit: U) {
        let Self { found, out } = self;
        for (tile, states) in found.iter().zip(out.chunks_mut(LANES)) {
            for (at, four) in tile.as_flattened().as_chunks::<4>().0.iter().enumerate() {
                let lanes = unit.transposed(*four);
                for (to, of) in states.iter_mut().zip(lanes) {
                    to[4 * at..4 * at + 4].copy_from_slice(&of);
                }
            }
        }
    }
}

impl Layout for HessianRow {
    fn fill(batch: &Batch, of: Slices<'_>, out: &mut [Self]) {
        batch.make(of, &mut Matrices { out });
    }
}

/// Matrices of each row.
struct Matrices<'l> {
    out: &'l mut [HessianRow],
}

impl Made for Matrices<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_tile(&mut self, at: usize, separation: Vector<Fused>, rows: &[RelativeRow], shapes: &[Shape]) {
        let each = shapes.len();
        let Some(out) = self.out.get_mut(at * each..(at + 1) * each) else { return };
        for k in 0..each {
            let (Some(row), Some(shape), Some(to)) = (rows.get(k), shapes.get(k), out.get_mut(k)) else {
                return;
            };
            with_constant!(*shape, |shape| row.put_nodal(shape, separation, to));
        }
    }
}

/// ∂²c[v, v] of each row.
struct Bias<'l> {
    velocities: &'l [Columns12],
    each: usize,
    out: &'l mut [Four],
}

impl Made for Bias<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_tile(&mut self, at: usize, separation: Vector<Fused>, rows: &[RelativeRow], shapes: &[Shape]) {
        let out = self.out.get_mut(at * self.each..(at + 1) * self.each);
        let (Some(v), Some(out)) = (self.velocities.get(at), out) else { return };
        let motion = Motion::of(v, separation);
        for k in 0..self.each {
            let (Some(row), Some(shape), Some(to)) = (rows.get(k), shapes.get(k), out.get_mut(k)) else {
                return;
            };
            with_constant!(*shape, |shape| row.read(shape, separation).bias(&motion)).store(to);
        }
    }
}

/// (Σ λ ∂²c) v.
struct Along<'l> {
    multipliers: &'l [Four],
    along: &'l [Columns12],
    each: usize,
    out: &'l mut [Columns12],
}

impl Made for Along<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_tile(&mut self, at: usize, separation: Vector<Fused>, rows: &[RelativeRow], shapes: &[Shape]) {
        let multipliers = self.multipliers.get(at * self.each..(at + 1) * self.each);
        let (Some(multipliers), Some(v), Some(out)) = (multipliers, self.along.get(at), self.out.get_mut(at))
        else {
            return;
        };
        let motion = Motion::of(v, separation);
        // Rows of one shape are summed first: the code for it has nothing of what they have not.
        for k in 0..self.each {
            let Some((before, [own, ..])) = shapes.split_at_checked(k) else { return };
            if before.contains(own) {
                continue;
            }
            with_constant!(*own, |shape| {
                let mut sum = Derivatives { shape, separation, ..Derivatives::NONE };
                for k in k..self.each {
                    let (Some(row), Some(of), Some(multiplier)) =
                        (rows.get(k), shapes.get(k), multipliers.get(k))
                    else {
                        return;
                    };
                    if *of == shape {
                        sum.add(Lanes(*multiplier), &row.read(shape, separation));
                    }
                }
                sum.along(&motion, out);
            });
        }
    }
}

/// The relative variations of a motion whose velocities are constant, and their rates.
struct Motion {
    /// ω_a.
    of_a: Vector<Fused>,
    /// ẋ_b − ẋ_a and ω_b.
    of_b: [Vector<Fused>; 2],
    /// δ̇ = ẋ_b − ẋ_a + D × ω_a and ρ̇ = ω_b − ω_a.
    rate: [Vector<Fused>; 2],
    /// δ̈ = ω_a × (ω_a × D − 2 (ẋ_b − ẋ_a)) and ρ̈ = ω_b × ω_a.
    second: [Vector<Fused>; 2],
}

impl Motion {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of(v: &Columns12, separation: Vector<Fused>) -> Self {
        let part =
            |from: usize| -> Vector<Fused> { [Lanes(v[from]), Lanes(v[from + 1]), Lanes(v[from + 2])] };
        let [x_a, w_a, x_b, w_b] = [part(0), part(3), part(6), part(9)];
        let apart = sub(x_b, x_a);
        let swept = cross(w_a, separation);
        Self {
            of_a: w_a,
            of_b: [apart, w_b],
            rate: [sub(apart, swept), sub(w_b, w_a)],
            second: [
                cross(w_a, sub(swept, [apart[0] + apart[0], apart[1] + apart[1], apart[2] + apart[2]])),
                cross(w_b, w_a),
            ],
        }
    }
}

impl Derivatives {
    /// ∂²c[v, v] = g·δ̈ + h·ρ̈ + the second derivatives by δ̇ and ρ̇, twice.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bias(&self, of: &Motion) -> Fused {
        let Shape { translation, rotation, quadratic, mixed, turns_with_a } = self.shape;
        let [by_delta, by_rho] = if turns_with_a { of.rate } else { of.of_b };
        let [dd, dr, rr] = &self.second;
        let mut sum = Lanes::splat(0.0);
        if quadratic {
            sum = dot(by_delta, apply(dd, by_delta));
        }
        if mixed {
            let both = dot(by_delta, apply(dr, by_rho));
            sum = sum + (both + both);
        }
        if rotation {
            sum = sum + dot(by_rho, apply(rr, by_rho));
        }
        if turns_with_a && translation {
            sum = sum + dot(self.translation, of.second[0]);
        }
        if turns_with_a && rotation {
            sum = sum + dot(self.rotation, of.second[1]);
        }
        sum
    }

    /// Adds ∂²c v by x_a, θ_a, x_b, θ_b: half the gradient of ∂²c[v, v].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn along(&self, of: &Motion, out: &mut Columns12) {
        let Shape { translation, rotation, quadratic, mixed, turns_with_a } = self.shape;
        let [by_delta, by_rho] = if turns_with_a { of.rate } else { of.of_b };
        let [dd, dr, rr] = &self.second;
        let (g, h, arm, turn) = (self.translation, self.rotation, self.separation, of.of_a);
        let [apart, turn_of_b] = of.of_b;
        let half = Lanes::splat(0.5);
        let [mut force, mut moment, mut of_a] = [[Lanes::splat(0.0); 3]; 3];
        if quadratic {
            force = apply(dd, by_delta);
        }
        if mixed {
            force = add(force, apply(dr, by_rho));
            moment = apply_transposed(dr, by_delta);
        }
        if rotation {
            moment = add(moment, apply(rr, by_rho));
        }
        if turns_with_a && translation {
            of_a = cross(force, arm);
            force = add(force, cross(turn, g));
            let (along, across) = (dot(turn, arm), dot(g, turn));
            let swept = sub(times(add(times(g, along), times(arm, across)), half), times(turn, dot(g, arm)));
            of_a = add(of_a, add(swept, cross(g, apart)));
        }
        if turns_with_a && rotation {
            of_a = sub(of_a, moment);
            of_a = add(of_a, times(cross(h, turn_of_b), half));
            moment = add(moment, times(cross(turn, h), half));
        }
        for i in 0..3 {
            let parts = [(i, -force[i]), (3 + i, of_a[i]), (6 + i, force[i]), (9 + i, moment[i])];
            for (to, part) in parts {
                let both: Fused = Lanes(out[to]) + part;
                both.store(&mut out[to]);
            }
        }
    }
}

/// Σ λ ∂²c.
struct Stiffness<'l> {
    multipliers: &'l [Four],
    each: usize,
    out: &'l mut [[Columns12; 12]],
}

impl Made for Stiffness<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_tile(&mut self, at: usize, separation: Vector<Fused>, rows: &[RelativeRow], shapes: &[Shape]) {
        let multipliers = self.multipliers.get(at * self.each..(at + 1) * self.each);
        let (Some(multipliers), Some(out)) = (multipliers, self.out.get_mut(at)) else { return };
        // What does not change as a turns has columns of zeros, and is no part of the other sum.
        let mut is_first = true;
        for turns_with_a in [true, false] {
            let all = Shape::all(shapes, turns_with_a);
            if all == Shape::NONE {
                continue;
            }
            let mut sum = Derivatives { shape: all, separation, ..Derivatives::NONE };
            for k in 0..self.each {
                let (Some(row), Some(shape), Some(multiplier)) =
                    (rows.get(k), shapes.get(k), multipliers.get(k))
                else {
                    return;
                };
                if shape.turns_with_a == turns_with_a {
                    sum.add(Lanes(*multiplier), &row.read(*shape, separation));
                }
            }
            if is_first {
                with_constant!(all, |all| Derivatives { shape: all, ..sum }.put_second(out));
                is_first = false;
                continue;
            }
            let mut other = [[[0.0; 4]; 12]; 12];
            sum.put_second(&mut other);
            for i in 0..144 {
                let (row, column) = (i / 12, i % 12);
                let both: Fused = Lanes(out[row][column]) + Lanes(other[row][column]);
                both.store(&mut out[row][column]);
            }
        }
    }
}
