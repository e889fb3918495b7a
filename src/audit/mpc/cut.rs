//! Half a turn of violation, where ρ jumps to its opposite. On either side it is a smooth function, which goes on beyond the half turn as
//! ρ − 2π ρ/|ρ|: the two are the sheets of the rotation vector.
//!
//! Where rounding decides on which side a state is, both values are right, and each has derivatives, those of its sheet. Numbers
//! are judged on the sheet that their value is on, with the conditioned scale of that. A value, rows, second derivatives and rates
//! of different sheets are wrong, and so is a value beyond half a turn by more than rounding.

use crate::judge::bound::C;
use crate::mpc::WideConstraint;
use pintle_kinematics::mpc::{Dofs, FLOW, RHO, Rows};
use pintle_kinematics::scalar::{Real, Scalar, U, Wide};
use pintle_kinematics::vector::{Vector, dot, scale};
use std::f64::consts::FRAC_PI_2;

/// The sheet of ρ that a state is on.
#[derive(Clone, Copy)]
pub(super) struct Sheet {
    /// ρ there.
    rho: Vector<Wide>,
    /// Whether rounding decides that it is this one.
    pub(super) is_undetermined: bool,
}

impl Sheet {
    /// The same equations, ρ on this sheet.
    pub(super) fn of(&self, mut rows: Rows<Wide>) -> Rows<Wide> {
        let Some(rho) = rotation(&rows) else { return rows };
        if dot(rho, self.rho) < Wide::zero() {
            let (direction, angle) = Wide::direction_and_norm(rho);
            let beyond = scale(direction, angle - Wide::integer(2) * Wide::pi());
            for (row, entry) in rows[RHO..FLOW].iter_mut().zip(beyond) {
                *row = Some(entry);
            }
        }
        rows
    }
}

/// ρ, where there are such equations.
fn rotation<R: Copy>(rows: &Rows<R>) -> Option<Vector<R>> {
    Some([rows[RHO]?, rows[RHO + 1]?, rows[RHO + 2]?])
}

impl WideConstraint {
    /// The same with the sheet of ρ that is principal at the state, or where rounding decides which one is, that of the numbers `got`;
    /// `inputs` are the magnitudes of what is rounded.
    pub(super) fn on_the_sheet(mut self, got: &Rows<f64>, inputs: &Dofs<f64>) -> Self {
        let Some(rho) = rotation(&self.values_of(self.given)) else { return self };
        let (_, angle) = Wide::direction_and_norm(rho);
        // Far from half a turn there is one alone.
        if angle.to_f64() < FRAC_PI_2 {
            return self;
        }
        self.sheet = Some(Sheet { rho, is_undetermined: false });
        let first = self.first();
        let conditioned = (RHO..FLOW).map(|row| {
            let slopes = first
                .iter()
                .zip(inputs)
                .map(|(along, input)| along[row].map_or(0.0, |slope| slope.abs().to_f64()) * input);
            slopes.sum::<f64>()
        });
        let conditioned = angle.to_f64() + conditioned.fold(0.0, f64::max);
        let is_undetermined = (Wide::pi() - angle).to_f64() <= C * U * conditioned;
        let of_got = rotation(got).map(|got| got.map(Wide::from_f64));
        let other = of_got.filter(|got| is_undetermined && dot(*got, rho) < Wide::zero());
        self.sheet = Some(Sheet { rho: other.unwrap_or(rho), is_undetermined });
        self
    }

    /// Whether rounding decides which sheet of ρ an equation is on.
    pub(super) fn is_undetermined(&self, row: usize) -> bool {
        (RHO..FLOW).contains(&row) && self.sheet.is_some_and(|sheet| sheet.is_undetermined)
    }
}

#[cfg(test)]
mod tests {
    use crate::case::failing::MpcCase;
    use crate::case::quantity::Quantity;
    use crate::judge::table::ResultTable;
    use crate::judge::verdict::Verdict;
    use crate::settings::{Planted, Settings};
    use pintle_kinematics::connector::Turns;
    use pintle_kinematics::mpc::{Body, Constraint, MpcType, State, Turning};
    use pintle_kinematics::so3::exp;
    use std::f64::consts::{FRAC_1_SQRT_2, PI};

    /// Nodes turned by these rotation vectors, and hinges by these angles; everything moves.
    fn case(kind: MpcType, [slave, master]: [[f64; 3]; 2], angles: [f64; 2]) -> MpcCase {
        let body = |rotation, displacement| Body { displacement, rotation: exp(rotation), flow: 0.0 };
        let hinges = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        MpcCase {
            name: format!("{} S {slave:?} M {master:?} φ {angles:?}", kind.name()),
            constraint: Constraint::new(kind, [1.0, 0.0, 0.5], [0.0; 3], hinges),
            state: State {
                slave: body(slave, [0.1, -0.3, 0.2]),
                master: body(master, [0.0, 0.25, -0.5]),
                angles: angles.map(Some),
                velocity: std::array::from_fn(|j| 0.3 + 0.1 * j as f64),
                acceleration: std::array::from_fn(|j| 0.5 - 0.07 * j as f64),
            },
            turning: Turning::none(),
            before: [Turns { turns: 0.0, principal: 0.0 }; 2],
            length: 1.0,
        }
    }

    /// Half a turn of violation, on the sheet that rounding decides: both of one and of the other kind.
    fn half_turns() -> Vec<MpcCase> {
        let common = [1.404_188_100_699_757_9, -1.234_197_732_547_400_3, -0.533_738_531_924_241_9];
        let oblique = [PI * FRAC_1_SQRT_2, PI * FRAC_1_SQRT_2, 0.0];
        let mut found = vec![
            case(MpcType::Revolute, [common, common], [-PI, 0.0]),
            case(MpcType::Beam, [[0.0, 0.0, -PI], oblique.map(|x| x * 2.0)], [0.0; 2]),
        ];
        // About this axis the product and 237 bits are on different sides.
        let (nodes, joint) = ([1.0, 0.0, 0.790_475_062_762_647_1], [0.0, 0.0, 0.346_265_399_890_325_56]);
        found[0].constraint = Constraint::new(MpcType::Revolute, nodes, nodes, [joint, [0.0; 3]]);
        for kind in [MpcType::Revolute, MpcType::Universal, MpcType::Beam, MpcType::Tie] {
            for master in [[0.0; 3], [1.0, 2.0, 3.0], [0.0, PI, 0.0]] {
                for slave in [[PI, 0.0, 0.0], [0.0, 0.0, PI], oblique] {
                    for angle in [0.0, PI] {
                        found.push(case(kind, [slave, master], [angle, -0.5 * angle]));
                    }
                }
            }
        }
        found
    }

    fn of(tables: &[ResultTable], quantity: Quantity) -> &ResultTable {
        tables.iter().find(|table| table.quantity == quantity).unwrap()
    }

    /// Rounding decides the sign of the value there: no number of the product is wrong, and none beside it passes.
    #[test]
    fn half_turns_are_judged_on_their_sheet() {
        let mut undetermined = 0;
        for case in half_turns() {
            for check in case.audit(&Settings::default(), false) {
                assert!(!check.verdict.is_mismatch(), "{}: {check:?}", case.name);
                undetermined += usize::from(check.verdict == Verdict::Singular);
            }
            let planted = Settings { planted: Some(Planted::WrongEntry), ..Settings::default() };
            let told = case.audit(&planted, false);
            assert!(told.iter().any(|check| check.verdict == Verdict::Wrong), "{}", case.name);
            let tables = case.tables();
            for quantity in MpcCase::QUANTITIES {
                let table = of(&tables, quantity);
                let largest = table.entries.iter().map(|entry| entry.got.abs()).fold(0.0, f64::max);
                // Some of the second derivatives: no two rows alike.
                let every = if quantity == Quantity::SecondDerivatives { 61 } else { 1 };
                for (i, entry) in table.entries.iter().enumerate().step_by(every) {
                    let mut wrong = table.clone();
                    wrong.entries[i].got += 1e-9 * largest.max(1.0);
                    assert_eq!(wrong.judge().verdict, Verdict::Wrong, "{}: {}", case.name, entry.name);
                }
            }
        }
        assert!(undetermined > 20, "{undetermined}");
    }

    /// Beyond rounding there is one sheet: the opposite is wrong.
    #[test]
    fn a_value_beyond_half_a_turn_is_wrong() {
        for gap in [1e-3, 1e-9, 1e-13] {
            let case = case(MpcType::Beam, [[0.0, 0.0, PI - gap], [0.0; 3]], [0.0; 2]);
            let tables = case.tables();
            assert!(tables.iter().all(|table| table.judge().verdict <= Verdict::IllConditioned), "{gap}");
            let table = of(&tables, Quantity::Value);
            let rho3 = table.entries.iter().position(|entry| entry.name == "ρ3").unwrap();
            let mut beyond = table.clone();
            beyond.entries[rho3].got -= 2.0 * PI;
            assert_eq!(beyond.judge().verdict, Verdict::Wrong, "{gap}");
        }
    }
}
