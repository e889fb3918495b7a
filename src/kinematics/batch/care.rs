//! Which lanes need more than a batch gives.

use crate::batch::fours::Plain;
use crate::batch::{Batch, Section, Tile};
use crate::connector::{Connector, Mask};
use crate::measure::Measure;
use crate::scalar::lanes::LANES;
use crate::vector::{apply_transposed, dot, transposed_product};

/// The singular sets of the components of connectors that share their measures, and a quick look at how far they are.
///
/// A lane that is not beside one is at least a hundred times as far as [`crate::connector::ILL_CONDITIONED`]: [`Connector::flags_of`] has
/// no flag of a singular set there. One that is beside may have one, by its [`Connector::margins`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch {
    /// The components that have a set.
    count: usize,
    /// Whether a tile does not tell how far they are: of a belt it has no flow.
    is_blind: bool,
    distance: bool,
    radius: bool,
    lock: bool,
    alignment: bool,
    reversal: bool,
    half_turn: bool,
    /// Rotation vectors, which a history turns on.
    turns: bool,
}

impl Watch {
    /// Over the components `wanted`.
    pub fn new(connector: &Connector<f64>, wanted: Mask) -> Self {
        let mut watch = Self::default();
        for k in (0..6).filter(|k| wanted[*k]) {
            let measures = [connector.differentiated(k), connector.position_measure(k)];
            let singular = measures.into_iter().flatten().filter(|measure| measure.singular_set().is_some());
            let mut any = false;
            for measure in singular {
                any = true;
                watch.add(measure);
            }
            watch.count += usize::from(any);
        }
        watch
    }

    const fn add(&mut self, measure: Measure) {
        match measure {
            Measure::Strain => self.is_blind = true,
            Measure::Distance => self.distance = true,
            Measure::RadialDistance => self.radius = true,
            Measure::Cardan(_) => self.lock = true,
            Measure::Euler(_) | Measure::Flexion | Measure::Sweep => self.alignment = true,
            Measure::Torsion | Measure::ComponentFlexion(_) | Measure::ProjectedPosition(_) => {
                self.reversal = true;
            }
            Measure::Misalignment(_) => self.half_turn = true,
            Measure::RotationVector(_) | Measure::RotationVectorAtB(_) => self.turns = true,
            Measure::Position(_)
            | Measure::PositionAtB(_)
            | Measure::Flow(_)
            | Measure::Cosine(..)
            | Measure::FlowConversion => {}
        }
    }

    /// The components that have a singular set.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Whether it looks at rotation vectors, of which a state by itself does not tell the turns. [`Watch::beside`] leaves them out:
    /// those that continue one shorter than 3 rad are far from whole turns.
    pub const fn turns(&self) -> bool {
        self.turns
    }

    /// Which lanes may be beside a singular set. A lane without numbers may.
    pub fn beside(&self, tile: &Tile, section: &Section) -> [bool; LANES] {
        /// The square of an angle (rad), or of a length as a part of the largest that it is formed from.
        const NEAR: f64 = 1e-12;
        let pair = tile.pair::<false>();
        let mut beside = [self.is_blind; LANES];
        let mut add = |square: Plain, size: Plain, counts: Plain| {
            for lane in 0..LANES {
                let is_far = square.0[lane] > NEAR * size.0[lane] || counts.0[lane] < 0.0;
                beside[lane] |= !is_far;
            }
        };
        let one = Plain::splat(1.0);
        if self.distance || self.radius {
            let separation = pair.separation();
            let lengths = [pair.reference, pair.a.displacement, pair.b.displacement];
            let mut largest = Plain::splat(0.0);
            for length in lengths.as_flattened() {
                for lane in 0..LANES {
                    largest.0[lane] = largest.0[lane].max(length.0[lane].abs());
                }
            }
            let size = largest * largest;
            if self.distance {
                add(dot(separation, separation), size, one);
            }
            if self.radius {
                let [x, y, _] = apply_transposed(&pair.a.triad, separation);
                add(x * x + y * y, size, one);
            }
        }
        if self.lock || self.alignment || self.reversal || self.half_turn {
            let q = transposed_product(&pair.a.triad, &pair.b.triad);
            if self.lock {
                add(q[1][2] * q[1][2] + q[2][2] * q[2][2], one, one);
            }
            let lateral = q[0][2] * q[0][2] + q[1][2] * q[1][2];
            if self.alignment {
                add(lateral, one, one);
            }
            if self.reversal {
                add(lateral, one, -q[2][2]);
            }
            if self.half_turn {
                // It is 1 + 2 cos of the angle.
                let initial = section.load::<false>().initial_orientation;
                let trace = (0..3).fold(Plain::splat(0.0), |sum, i| sum + dot(q[i], initial[i]));
                add(trace + one, Plain::splat(1e3), one);
            }
        }
        beside
    }
}

impl Batch {
    /// In which lanes the nodes are as far from each other as rows are stated for: 1e-300 to 1e300, or nearer where no row is that of a
    /// length. Beyond it a row may be zero that is not.
    pub fn takes(&self, tile: &Tile) -> [bool; LANES] {
        const NEAR: f64 = 1e-300;
        let apart = tile.pair::<false>().separation();
        let mut takes = [false; LANES];
        for (lane, takes) in takes.iter_mut().enumerate() {
            let [x, y, z] = apart.each_ref().map(|of| of.0[lane].abs());
            // A comparison with NaN does not hold.
            let is_near = x <= 1.0 / NEAR && y <= 1.0 / NEAR && z <= 1.0 / NEAR;
            *takes = is_near && (!self.has_length || x >= NEAR || y >= NEAR || z >= NEAR);
        }
        takes
    }
}
