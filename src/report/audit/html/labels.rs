//! Where names stand in a drawing: not on each other, not on lines if that can be helped, not outside of the picture.

/// From one line of text to the next.
const LINE: f64 = 13.0;

/// How far the letters reach below the line that they stand on.
const BELOW: f64 = 3.0;

/// Distances from what is named that are tried, in turn.
const GAPS: [f64; 5] = [7.0, 12.0, 18.0, 28.0, 42.0];

/// What it costs to cover other text, per area of it.
const ON_TEXT: f64 = 6.0;

/// What it costs to cover a line, per length of it.
const ON_LINE: f64 = 1.0;

/// What it costs to stand outside of the picture.
const OUTSIDE: f64 = 1e6;

/// A place that is taken: left, top, right, bottom.
#[derive(Clone, Copy)]
pub(super) struct Area(pub(super) [f64; 4]);

impl Area {
    /// Of a text that begins at a point of its line.
    fn of_text([x, y]: [f64; 2], width: f64) -> Self {
        Self([x, y - (LINE - BELOW), x + width, y + BELOW])
    }

    fn common(&self, other: &Self) -> f64 {
        let overlap = |low: usize, high: usize| {
            (self.0[high].min(other.0[high]) - self.0[low].max(other.0[low])).max(0.0)
        };
        overlap(0, 2) * overlap(1, 3)
    }

    /// The length of the part of a segment inside.
    pub(super) fn covered(&self, [from, to]: &[[f64; 2]; 2]) -> f64 {
        let mut part = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let (low, high, step) = (self.0[axis], self.0[axis + 2], to[axis] - from[axis]);
            if step.abs() < 1e-9 {
                if from[axis] < low || from[axis] > high {
                    return 0.0;
                }
                continue;
            }
            let (x, y) = ((low - from[axis]) / step, (high - from[axis]) / step);
            part = (part.0.max(x.min(y)), part.1.min(x.max(y)));
        }
        (part.1 - part.0).max(0.0) * (to[0] - from[0]).hypot(to[1] - from[1])
    }
}

/// What is in the picture already.
pub(super) struct Labels {
    size: [f64; 2],
    taken: Vec<Area>,
    lines: Vec<[[f64; 2]; 2]>,
}

impl Labels {
    /// An empty picture.
    pub(super) const fn new(size: [f64; 2]) -> Self {
        Self { size, taken: Vec::new(), lines: Vec::new() }
    }

    /// A line that names should not cover.
    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.lines.push([from, to]);
    }

    /// A circle, or a small text in the middle of one, that names must not cover.
    pub(super) fn spot(&mut self, [x, y]: [f64; 2], radius: f64) {
        self.taken.push(Area([x - radius, y - radius, x + radius, y + radius]));
    }

    /// Where a text of this width begins that names what is at any of some points, the best first.
    pub(super) fn place(&mut self, points: &[[f64; 2]], width: f64) -> [f64; 2] {
        let mut best: Option<(f64, [f64; 2])> = None;
        let mut rank = 0.0;
        for gap in GAPS {
            for [x, y] in points {
                let (left, right, middle) = (x - gap - width, x + gap, x - width / 2.0);
                let (above, below, level) = (y - gap - BELOW, y + gap + LINE - BELOW, y + LINE / 2.0 - BELOW);
                let around = [
                    [right, above],
                    [right, below],
                    [left, above],
                    [left, below],
                    [right, level],
                    [left, level],
                    [middle, above],
                    [middle, below],
                ];
                for at in around {
                    rank += 0.05;
                    let cost = rank + self.cost(&Area::of_text(at, width));
                    if best.is_none_or(|(least, _)| cost < least) {
                        best = Some((cost, at));
                    }
                }
            }
        }
        let at = best.map_or([0.0; 2], |(_, at)| at.map(|x| (x * 10.0).round() / 10.0));
        self.taken.push(Area::of_text(at, width));
        at
    }

    fn cost(&self, area: &Area) -> f64 {
        let [left, top, right, bottom] = area.0;
        let is_outside = left < 2.0 || top < 2.0 || right > self.size[0] - 2.0 || bottom > self.size[1] - 2.0;
        let of_text: f64 = self.taken.iter().map(|other| area.common(other)).sum();
        let of_lines: f64 = self.lines.iter().map(|line| area.covered(line)).sum();
        ON_TEXT * of_text + ON_LINE * of_lines + if is_outside { OUTSIDE } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::{Area, Labels};

    #[test]
    fn names_stand_beside_each_other_and_inside() {
        let mut labels = Labels::new([300.0, 200.0]);
        labels.line([0.0, 100.0], [300.0, 100.0]);
        let placed: Vec<Area> =
            (0..6).map(|_| Area::of_text(labels.place(&[[150.0, 100.0]], 60.0), 60.0)).collect();
        for (i, one) in placed.iter().enumerate() {
            assert!(placed[..i].iter().all(|other| one.common(other) == 0.0), "{:?}", one.0);
            assert_eq!(one.covered(&[[0.0, 100.0], [300.0, 100.0]]), 0.0, "{:?}", one.0);
            assert!(one.0[0] > 0.0 && one.0[1] > 0.0 && one.0[2] < 300.0 && one.0[3] < 200.0, "{:?}", one.0);
        }
        // In a corner there is but one way.
        let at = labels.place(&[[298.0, 2.0]], 60.0);
        assert!(at[0] + 60.0 < 300.0 && at[1] > 10.0, "{at:?}");
    }
}
