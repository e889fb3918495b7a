//! When do steps end, and which states belong to them?

use pintle_scene::{Procedure, Scene, State, Step};

/// The times at which the steps end, where all are known: without a period a static step lasts 1, and a perturbation takes no time.
pub fn ends(scene: &Scene) -> Option<Vec<f64>> {
    let mut now = 0.0;
    let end = |step: &Step| {
        if !step.perturbation {
            now += match &step.procedure {
                Some(Procedure::Static(times)) => times.total.unwrap_or(1.0),
                Some(Procedure::Dynamic { times, .. }) => times.total?,
                _ => return None,
            };
        }
        Some(now)
    };
    scene.steps.iter().map(end).collect()
}

/// The step, counted from 1, that a state belongs to: the first that ends no earlier, or the last. Where times are not known, the first.
pub fn of_state(ends: Option<&[f64]>, state: &State) -> usize {
    /// Times are rounded.
    const SAME: f64 = 1e-9;
    let (Some(ends), Some(time)) = (ends, state.time) else { return 1 };
    let last = ends.last().copied().unwrap_or_default();
    let at = ends.iter().position(|end| time <= end + SAME * last.abs());
    at.map_or(ends.len().max(1), |at| at + 1)
}
