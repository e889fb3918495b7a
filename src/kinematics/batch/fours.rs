//! Four connectors that share their measures, from state to state: where they are, what their histories decide, what they give.

use crate::batch::tile::{Four, four, matrix, vector};
use crate::batch::{History, Moves, Section, Tile};
use crate::connector::{Branch, Connector, Follower, Increment, Mask, Tally, Turns};
use crate::measure::{self, Measure, Shared};
use crate::node::Dependence;
use crate::scalar::Real;
use crate::scalar::lanes::{LANES, Lanes};
use crate::vector::{Matrix, Vector};

/// Lanes of any processor.
pub(super) type Plain = Lanes<false>;

/// From where the values of one component are counted.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    /// The initial position.
    pub initial: Four,
    /// That of the residual of a constrained component.
    pub residual: Four,
    /// The reference of its behaviour.
    pub reference: Four,
}

/// Four connectors that share their measures ([`Connector::has_measures_of`]), and what they remember.
#[derive(Clone, Debug)]
pub struct Fours {
    initial: [[[Four; 3]; 3]; 2],
    section: Section,
    /// β_s and the initial lengths, which histories of material flow need.
    flow: [Four; 2],
    origins: [Option<Origin>; 6],
    branch: Branch<Plain>,
    tile: Tile,
}

impl Fours {
    /// Four connectors at their initial state, each with X_b − X_a and the initial triads of its nodes.
    pub fn new(
        of: &[&Connector<f64>; LANES],
        references: &[Vector<f64>; LANES],
        triads: &[[Matrix<f64>; 2]; LANES],
    ) -> Self {
        let origin = |k: usize| {
            of[0].origin(k)?;
            Some(Origin {
                initial: four(of, |one| one.counts_from(k).unwrap_or(f64::NAN)),
                residual: four(of, |one| one.origin(k).unwrap_or(f64::NAN)),
                reference: four(of, |one| one.reference(k).unwrap_or(f64::NAN)),
            })
        };
        let initial = [0, 1].map(|end| matrix(triads, |one| one[end]));
        Self {
            initial,
            section: Section::new(of),
            flow: [four(of, |one| one.section().flow_scale), four(of, |one| one.section().initial_length)],
            origins: [0, 1, 2, 3, 4, 5].map(origin),
            branch: branches(&of.map(Connector::initial_branch)),
            tile: Tile {
                reference: vector(references, |one| *one),
                displacement: [[[0.0; LANES]; 3]; 2],
                triad: initial,
            },
        }
    }

    /// The same, where the past has left these branches.
    #[must_use]
    pub fn resumed(self, of: &[Branch<f64>; LANES]) -> Self {
        Self { branch: branches(of), ..self }
    }

    /// Brings them to the next state, by what [`Fours::follow`] says.
    pub fn follow_moves(
        &mut self,
        kind: &Connector<f64>,
        moves: &Moves,
        history: Option<(&[Increment<f64>; LANES], Mask)>,
        tally: &mut Tally,
    ) {
        self.tile.place(&self.initial, moves);
        self.follow_history(kind, history, tally);
    }

    /// Brings them to the next state. Where a `history` depends on how the nodes turn ([`Connector::history_turns`]) that of the components named
    /// is followed along the increments, by the rule of [`Connector::follow`]; `kind` is one of the connectors.
    pub fn follow(
        &mut self,
        kind: &Connector<f64>,
        tile: Tile,
        history: Option<(&[Increment<f64>; LANES], Mask)>,
        tally: &mut Tally,
    ) {
        self.tile = tile;
        self.follow_history(kind, history, tally);
    }

    fn measured(&self) -> measure::Section<Plain> {
        let [flow_scale, initial_length] = self.flow.map(Lanes);
        measure::Section { flow_scale, initial_length, ..self.section.load() }
    }

    fn follow_history(
        &mut self,
        kind: &Connector<f64>,
        history: Option<(&[Increment<f64>; LANES], Mask)>,
        tally: &mut Tally,
    ) {
        let Some((of, wanted)) = history else { return };
        let increment = Increment {
            rotation: [0, 1].map(|end| vector(of, |one| one.rotation[end]).map(Lanes)),
            whole_turns: [0, 1].map(|end| vector(of, |one| one.whole_turns[end]).map(Lanes)),
            flow: [0, 1].map(|end| Lanes(four(of, |one| one.flow[end]))),
        };
        let mut work = Tally::default();
        let section = self.measured();
        let follower = Follower { rows: kind.rows(), section: &section };
        self.branch = follower.follow(&self.tile.pair(), &increment, &self.branch, wanted, &mut work);
        tally.histories += LANES as u64 * work.histories;
    }

    /// Where they are.
    pub const fn tile(&self) -> &Tile {
        &self.tile
    }

    /// Their data.
    pub const fn section(&self) -> &Section {
        &self.section
    }

    /// What the past decides of the rows here.
    pub const fn history(&self) -> History {
        let Branch { rotation_vector: [x, y, z], euler_sign, torsion, .. } = self.branch;
        History { rotation_vector: [x.0, y.0, z.0], euler_sign: euler_sign.0, torsion_turns: torsion.turns.0 }
    }

    /// From where component k (0-based) is counted; `None` where there is none.
    pub fn origin(&self, k: usize) -> Option<&Origin> {
        self.origins.get(k)?.as_ref()
    }

    /// The whole turns of component k (0-based), and its principal angle (rad); of one that does not wind, as at first.
    pub fn turns(&self, k: usize) -> [Four; 2] {
        self.branch.turns.get(k).map_or([[f64::NAN; LANES]; 2], |of| [of.turns.0, of.principal.0])
    }

    /// An angle that winds, less an origin: principal parts are differenced, so that turns cost no digits.
    pub fn angle(&self, k: usize, origin: &Four) -> Four {
        let of = self.branch.turns.get(k);
        of.map_or([f64::NAN; LANES], |of| Plain::with_turns(of.principal - Lanes(*origin), of.turns).0)
    }

    /// The value of a measure here, on the sheets that the past decides.
    pub fn value(&self, measure: Measure) -> Four {
        let Branch { rotation_vector, euler_sign, torsion, .. } = self.branch;
        let history = measure::History { rotation_vector, euler_sign, torsion_turns: torsion.turns };
        let (pair, section) = (self.tile.pair(), self.measured());
        let needed: Dependence = measure.dependence();
        let zero = [Lanes::splat(0.0); 3];
        let relative = pair.varied(needed, zero, zero, [Lanes::splat(0.0); 2]);
        measure.evaluate(&mut Shared::new(&relative, &pair.a.triad, &section, &history)).0
    }

    /// What the connector of a lane remembers.
    pub fn branch(&self, lane: usize) -> Branch<f64> {
        branch(&self.branch, lane)
    }
}

fn branches(of: &[Branch<f64>; LANES]) -> Branch<Plain> {
    let turns = |get: &dyn Fn(&Branch<f64>) -> Turns<f64>| Turns {
        turns: Lanes(four(of, |one| get(one).turns)),
        principal: Lanes(four(of, |one| get(one).principal)),
    };
    Branch {
        turns: [0, 1, 2, 3, 4, 5].map(|k| turns(&|one| one.turns[k])),
        rotation_vector: vector(of, |one| one.rotation_vector).map(Lanes),
        euler_sign: Lanes(four(of, |one| one.euler_sign)),
        torsion: turns(&|one| one.torsion),
        accumulated: Lanes(four(of, |one| one.accumulated)),
        accumulated_rest: Lanes(four(of, |one| one.accumulated_rest)),
    }
}

/// The branch of lane i.
fn branch(of: &Branch<Plain>, i: usize) -> Branch<f64> {
    let lane = |x: Plain| x.0.get(i).copied().unwrap_or(f64::NAN);
    let turns = |t: Turns<Plain>| Turns { turns: lane(t.turns), principal: lane(t.principal) };
    Branch {
        turns: of.turns.map(turns),
        rotation_vector: of.rotation_vector.map(lane),
        euler_sign: lane(of.euler_sign),
        torsion: turns(of.torsion),
        accumulated: lane(of.accumulated),
        accumulated_rest: lane(of.accumulated_rest),
    }
}
