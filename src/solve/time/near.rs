//! Next to singular positions: which one is near, and how near?
//!
//! Angles by Cardan or Euler lock where two of their axes are one. A step must not jump over that: the angles are others on the other side. Constraints
//! that become combinations of each other, as of a crank at its dead position, leave forces without bound: steps there are ever shorter.

use crate::motion::rows::{Instant, Layout};
use crate::motion::state::DOFS;
use crate::number::Number;
use crate::refusal::Refusal;
use crate::time::run::Run;
use crate::time::step::WINDOW;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::{cross, dot};

/// The part of the way to a lock that one step goes.
const PART: f64 = 0.9;

/// The angle to a lock (rad) below which forces on its angles have no digits left.
const LOCKED: f64 = 1e-7;

/// A position is near to a singular one where a constraint repeats others but for less than this part.
const NEAR: f64 = 0.03;

impl<R: Number> Run<'_, R> {
    /// How far the angles of each connector are from their lock (rad), and how fast they go away from it, where something depends on them.
    fn locks(&self) -> Vec<(usize, [f64; 2])> {
        let still = vec![[R::ZERO; 3]; self.state.poses.len()];
        let instant = Instant::of(&self.state, self.step, &still);
        let joints = self.mechanism.joints.iter().enumerate();
        let found = joints.filter_map(|(index, joint)| {
            let mut wanted = (0..6).filter(|k| joint.wanted[*k] && !joint.constrained[*k]);
            let axis = wanted.find_map(|k| match joint.connector.position_measure(k)? {
                Measure::Cardan(_) => Some(0),
                Measure::Euler(_) => Some(2),
                _ => None,
            })?;
            let state = self.mechanism.pair_state(index, &instant);
            // They lock where this axis of a and the third of b are one, along it or against it.
            let [of_a, of_b] = [(state.pair.a.triad, axis), (state.pair.b.triad, 2)]
                .map(|(triad, k)| [0, 1, 2].map(|i| triad[i][k].to_f64()));
            let spin = [3, 4, 5].map(|k| (state.velocity[DOFS + k] - state.velocity[k]).to_f64());
            let (along, across) = (dot(of_a, of_b), norm(cross(of_a, of_b)));
            let rate = -dot(of_a, cross(spin, of_b)) * along.signum() / across.max(f64::MIN_POSITIVE);
            Some((index, [across.atan2(along.abs()), rate]))
        });
        found.collect()
    }

    /// How long a step may be at most for the locks of angles that it approaches, on which something depends.
    ///
    /// # Errors
    /// One of them has locked, but for rounding.
    pub(crate) fn until_lock(&self) -> Result<f64, Refusal> {
        let mut least = f64::INFINITY;
        for (index, [angle, rate]) in self.locks() {
            if angle <= LOCKED {
                return Err(self.locked(index, angle));
            }
            if rate < 0.0 {
                least = least.min(-angle / rate);
            }
        }
        Ok(PART * least)
    }

    fn locked(&self, joint: usize, angle: f64) -> Refusal {
        let time = self.state.time.to_f64();
        Refusal::of(
            self.joint_title(joint),
            &format!("its angles lock at time {time}: two of their axes are one but for {angle:.0e} rad"),
            "let nothing act on these angles, or turn the orientation of the connector",
        )
    }

    /// The singular position that is near, if one is.
    pub(crate) fn singular(&self) -> Option<Refusal> {
        let locks = self.locks().into_iter().map(|(joint, [angle, _])| (joint, angle));
        if let Some((joint, angle)) = locks.min_by(|one, two| one.1.total_cmp(&two.1))
            && angle < NEAR
        {
            return Some(self.locked(joint, angle));
        }
        let found = self.assembled(&self.modes).ok()?;
        let (left, owner) = Layout::new(&self.mechanism, &found, &self.modes).ok()?.nearest?;
        (left < NEAR).then(|| {
            let time = self.state.time.to_f64();
            Refusal::of(
                &self.mechanism.named(owner),
                &format!("a singular position is near at time {time}: it repeats other constraints but for a part of {left:.0e}"),
                "end before it, or change a length: there forces have no bound, or the motion may go on in several ways",
            )
        })
    }

    /// Refuses to go on by steps that would be too many, where they are short for a singular position.
    ///
    /// # Errors
    /// Which position it is.
    pub(crate) fn crawls(&mut self) -> Result<(), Refusal> {
        let now = self.state.time.to_f64();
        let Some(passed) = self.quiet.window(now) else { return Ok(()) };
        let ahead = (self.duration() - now) / passed * WINDOW as f64;
        if ahead <= self.options.most_steps as f64 {
            return Ok(());
        }
        self.singular().map_or(Ok(()), Err)
    }
}
