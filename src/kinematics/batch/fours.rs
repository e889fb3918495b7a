//! What four connectors that share their measures remember from state to state, and the values that it decides.

use crate::batch::tile::{Four, four, vector};
use crate::batch::{History, Section, Tile};
use crate::connector::{Branch, Connector, Follower, Increment, Mask, Tally, Turns};
use crate::measure::{self, Measure, Shared};
use crate::scalar::Real;
use crate::scalar::lanes::{LANES, Lanes};

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

/// What four connectors that share their measures ([`Connector::has_measures_of`]) remember, and from where they count.
#[derive(Clone, Debug)]
pub struct Fours {
    /// β_s and the initial lengths, which histories of material flow need.
    flow: [Four; 2],
    origins: [Option<Origin>; 6],
    branch: Branch<Plain>,
}

impl Fours {
    /// Four connectors at their initial state.
    pub fn new(of: &[&Connector<f64>; LANES]) -> Self {
        let origin = |k: usize| {
            of[0].origin(k)?;
            Some(Origin {
                initial: four(of, |one| one.counts_from(k).unwrap_or(f64::NAN)),
                residual: four(of, |one| one.origin(k).unwrap_or(f64::NAN)),
                reference: four(of, |one| one.reference(k).unwrap_or(f64::NAN)),
            })
        };
        Self {
            flow: [four(of, |one| one.section().flow_scale), four(of, |one| one.section().initial_length)],
            origins: [0, 1, 2, 3, 4, 5].map(origin),
            branch: branches(&of.map(Connector::initial_branch)),
        }
    }

    /// The same, where the past has left these branches.
    #[must_use]
    pub fn resumed(self, of: &[Branch<f64>; LANES]) -> Self {
        Self { branch: branches(of), ..self }
    }

    /// Follows the histories of the components wanted to a state, along increments since the one before, by the rule of [`Connector::follow`].
    /// `kind` is one of the connectors. It is needed where [`Connector::history_turns`].
    pub fn follow(
        &mut self,
        kind: &Connector<f64>,
        at: (&Tile, &Section),
        increments: &[Increment<f64>; LANES],
        wanted: Mask,
        tally: &mut Tally,
    ) {
        let increment = Increment {
            rotation: [0, 1].map(|end| vector(increments, |one| one.rotation[end]).map(Lanes)),
            whole_turns: [0, 1].map(|end| vector(increments, |one| one.whole_turns[end]).map(Lanes)),
            flow: [0, 1].map(|end| Lanes(four(increments, |one| one.flow[end]))),
        };
        let mut work = Tally::default();
        let (tile, section) = (at.0, self.measured(at.1));
        let follower = Follower { rows: kind.rows(), section: &section };
        self.branch = follower.follow(&tile.pair(), &increment, &self.branch, wanted, &mut work);
        tally.histories += LANES as u64 * work.histories;
    }

    fn measured(&self, section: &Section) -> measure::Section<Plain> {
        let [flow_scale, initial_length] = self.flow.map(Lanes);
        measure::Section { flow_scale, initial_length, ..section.load() }
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

    /// The value of a measure at a state, on the sheets that the past decides.
    pub fn value(&self, measure: Measure, (tile, section): (&Tile, &Section)) -> Four {
        let Branch { rotation_vector, euler_sign, torsion, .. } = self.branch;
        let history = measure::History { rotation_vector, euler_sign, torsion_turns: torsion.turns };
        let (pair, section) = (tile.pair(), self.measured(section));
        let zero = [Lanes::splat(0.0); 3];
        let relative = pair.varied(measure.dependence(), zero, zero, [Lanes::splat(0.0); 2]);
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
