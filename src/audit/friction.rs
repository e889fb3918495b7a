//! Predefined friction of a type: P, F_C, F_N and Φ with their derivatives by the forces, and the consistent tangent of an
//! increment, against differences on 237-bit numbers.
//!
//! Central differences of values with h = s·1e-25 give first, with h = s·1e-18 second derivatives: no dual number enters them.
//! s is the largest force, or the largest moment.

use super::engine::Settings;
use super::mutant::Mistake;
use super::oracle::Oracle;
use super::outcome::Check;
use super::quantity::Quantity;
use super::sample::Draw;
use super::sheet::{Change, Entry, Sheet};
use crate::behavior::friction::{
    Branch, Coefficient, Context, Criterion, Derivatives, FactorMistake, Friction, Input, Partial, Point,
    State, Status, StickStiffness,
};
use crate::catalog::{COMPONENT, ConnectionType, Contact, FORCE};
use crate::scalar::{Real, Scalar, Wide};

const FIRST_STEP: f64 = 1e-25;
const SECOND_STEP: f64 = 1e-18;

/// What is judged of a criterion, by name.
const PARTS: [&str; 4] = ["P", "F_C", "F_N", "Φ"];

/// A criterion at given forces.
#[derive(Clone, Debug)]
pub struct FrictionCase {
    name: String,
    criterion: Criterion,
    coefficient: f64,
    forces: [f64; 6],
    position: [f64; 6],
    displacement: [f64; 6],
    duration: f64,
    stick_stiffness: f64,
}

/// Cases of every predefined criterion of a type, spatial, with parameters and forces drawn; none for a type without, and for a
/// belt around a ring, whose law is another.
pub fn friction_cases(connection: &ConnectionType, settings: &Settings, count: usize) -> Vec<FrictionCase> {
    let mut found = Vec::new();
    let Some(friction) =
        connection.friction.filter(|f| f.criteria.iter().all(|c| c.contact != Contact::Belt))
    else {
        return found;
    };
    let draw = &mut Draw::new(&format!("{} {} friction", settings.seed, connection.name));
    for i in 0..count {
        let numbers: Vec<Option<f64>> =
            friction.parameters.iter().map(|_| Some(draw.between(0.2, 2.0))).collect();
        let Ok(criteria) = Criterion::predefined(&friction, &numbers, &[], false) else { continue };
        // Away from zero, where norms have no derivative.
        let mut six = |size: f64| {
            [0; 6].map(|_| {
                let x = draw.between(-size, size);
                if x < 0.0 { x - 0.1 * size } else { x + 0.1 * size }
            })
        };
        let (forces, position) = (six(3.0), six(0.8));
        // Some increments stick, some slip.
        let displacement = six([0.002, 0.05, 0.2][i % 3]);
        for (n, criterion) in criteria.into_iter().enumerate() {
            found.push(FrictionCase {
                name: format!("{} friction {} state {i}", connection.name, n + 1),
                criterion,
                coefficient: draw.between(0.05, 0.6),
                forces,
                position,
                displacement,
                duration: draw.between(0.01, 0.2),
                stick_stiffness: draw.between(20.0, 60.0),
            });
        }
    }
    found
}

impl FrictionCase {
    /// The criterion and the state, in words.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// All checks at this state, with mutants.
    pub fn audit(&self, settings: &Settings) -> Vec<Check> {
        if !settings.oracles.contains(&Oracle::WideDifferences) {
            return Vec::new();
        }
        let mut sheets = self.sheets();
        if let Some(planted) = settings.planted {
            sheets.iter_mut().for_each(|sheet| planted.spoil_sheet(sheet));
        }
        sheets.iter().map(|sheet| sheet.check(1.0, true, &self.name, None)).collect()
    }

    /// The numbers at this state, and what they must be: the criterion, its first and second derivatives, the tangent.
    pub fn sheets(&self) -> Vec<Sheet> {
        let mut sheets = self.criterion_sheets();
        sheets.extend(self.tangent_sheet());
        sheets
    }

    fn context<R: Real>(&self) -> Context<'static, R> {
        let position = self.position.map(R::from_f64);
        Context { position, motion: position, ..Context::default() }
    }

    /// The largest force, and the largest moment.
    fn sizes(&self) -> [f64; 6] {
        let largest = |of: &[f64]| of.iter().fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
        let (force, moment) = (largest(&self.forces[..3]), largest(&self.forces[3..]));
        [force, force, force, moment, moment, moment]
    }

    fn derivatives(&self, criterion: &Criterion) -> [Derivatives<f64>; 4] {
        let Point { tangential, contact, normal, criterion } =
            criterion.derivatives(&self.forces, self.coefficient, None, &self.context()).0;
        [tangential, contact, normal, criterion]
    }

    /// The parts at forces moved by multiples of the sizes.
    fn values(&self, by: [Wide; 6]) -> [Wide; 4] {
        let sizes = self.sizes();
        let forces: [Wide; 6] =
            std::array::from_fn(|k| Wide::from_f64(self.forces[k]) + by[k] * Wide::from_f64(sizes[k]));
        let coefficient = Wide::from_f64(self.coefficient);
        let Point { tangential, contact, normal, criterion } =
            self.criterion.at(&forces, coefficient, None, &self.context()).0;
        [tangential, contact, normal, criterion]
    }

    fn criterion_sheets(&self) -> Vec<Sheet> {
        let got = self.derivatives(&self.criterion);
        let sizes = self.sizes();
        let along = |k: usize, h: Wide| {
            let mut by = [Wide::zero(); 6];
            by[k] = h;
            by
        };
        let still = self.values([Wide::zero(); 6]);
        let h = Wide::from_f64(FIRST_STEP);
        let first: [[Wide; 4]; 6] = std::array::from_fn(|k| {
            let (plus, minus) = (self.values(along(k, h)), self.values(along(k, -h)));
            let width = (h + h) * Wide::from_f64(sizes[k]);
            std::array::from_fn(|p| (plus[p] - minus[p]) / width)
        });
        let g = Wide::from_f64(SECOND_STEP);
        let second: [[[Wide; 4]; 6]; 6] = std::array::from_fn(|k| {
            std::array::from_fn(|l| {
                let corner = |a: Wide, b: Wide| {
                    let mut by = along(k, a);
                    by[l] += b;
                    self.values(by)
                };
                let [pp, pm, mp, mm] = [corner(g, g), corner(g, -g), corner(-g, g), corner(-g, -g)];
                let area = Wide::integer(4) * g * g * Wide::from_f64(sizes[k]) * Wide::from_f64(sizes[l]);
                std::array::from_fn(|p| ((pp[p] - pm[p]) - (mp[p] - mm[p])) / area)
            })
        });
        // The nearest zero of a force is where a norm may have no derivative.
        let near = (0..6).fold(1.0_f64, |least, k| least.min(self.forces[k].abs() / sizes[k]));
        let mistaken: Vec<(Mistake, [Derivatives<f64>; 4])> = self
            .criterion
            .factor_mistakes()
            .into_iter()
            .map(|(mistake, criterion)| (Mistake::from(mistake), self.derivatives(&criterion)))
            .collect();
        let mut sheets = Vec::new();
        type Pick = fn(&Derivatives<f64>) -> Vec<f64>;
        let kinds: [(Quantity, Pick); 3] = [
            (Quantity::FrictionCriterion, |part| vec![part.value]),
            (Quantity::FrictionGradient, |part| part.gradient.to_vec()),
            (Quantity::FrictionHessian, |part| part.hessian.as_flattened().to_vec()),
        ];
        for (order, (quantity, pick)) in kinds.into_iter().enumerate() {
            let mut sheet = Sheet::new(quantity);
            let prefix = ["", "∂", "∂²"][order];
            sheet.rows = PARTS.map(|part| format!("{prefix}{part}")).into();
            if order == 1 {
                sheet.columns = FORCE.map(String::from).into();
            }
            for (p, part) in PARTS.iter().enumerate() {
                let sum = |k: usize| (0..6).map(|l| second[k][l][p].to_f64().abs() * sizes[l]).sum::<f64>();
                // Φ is a difference: what counts is what it is formed from.
                let parts = [&[0_usize][..], &[1], &[1, 2], &[0, 2]][p];
                let value: f64 = parts.iter().map(|part| still[*part].to_f64().abs()).sum();
                let f = value + (0..6).map(|k| first[k][p].to_f64().abs() * sizes[k]).sum::<f64>();
                let f2 = f + (0..6).map(|k| sum(k) * sizes[k]).sum::<f64>();
                for (i, got) in pick(&got[p]).into_iter().enumerate() {
                    let (k, l) = (i / 6, i % 6);
                    let (name, want, scale) = match order {
                        0 => ((*part).to_string(), still[p], f),
                        1 => (format!("∂{part}/∂{}", FORCE[i]), first[i][p], f / sizes[i] + sum(i)),
                        _ => (
                            format!("∂²{part}/∂{}∂{}", FORCE[k], FORCE[l]),
                            second[k][l][p],
                            f2 / (sizes[k] * sizes[l] * near),
                        ),
                    };
                    let class = [(0, 0, 0), (0, i / 3, 0), (0, k / 3, l / 3)][order];
                    sheet.entries.push(Entry { name, got, want, scale, class });
                }
            }
            sheet.mistakes = mistaken
                .iter()
                .map(|(mistake, wrong)| Change {
                    mistake: *mistake,
                    changes: wrong.iter().flat_map(pick).enumerate().collect(),
                })
                .collect();
            sheets.push(sheet);
        }
        sheets
    }

    fn friction(&self) -> Friction {
        Friction {
            criterion: self.criterion.clone(),
            coefficient: Coefficient::Constant(self.coefficient),
            maximum: None,
            stick_stiffness: StickStiffness::Given(self.stick_stiffness),
            radius: 1.0,
        }
    }

    /// Sizes of the inputs of an increment: Δu in slips that reach the limit, forces, Δt.
    fn input_sizes(&self, limit: f64) -> [f64; 13] {
        let forces = self.sizes();
        let slip = limit.abs() / self.stick_stiffness;
        std::array::from_fn(|j| match j {
            0..6 => self.displacement[j].abs() + slip,
            6..12 => forces[j - 6],
            _ => self.duration,
        })
    }

    fn input<R: Real>(&self, moved: Option<(usize, R)>) -> Input<'static, R> {
        let all = |x: [f64; 6]| x.map(R::from_f64);
        let mut input = Input {
            displacement: all(self.displacement),
            forces: all(self.forces),
            duration: Some(R::from_f64(self.duration)),
            context: self.context(),
        };
        match moved {
            // A displacement moves its position and motion too.
            Some((j @ 0..6, h)) => {
                for of in [&mut input.displacement, &mut input.context.position, &mut input.context.motion] {
                    of[j] = of[j] + h;
                }
            }
            Some((j @ 6..12, h)) => input.forces[j - 6] = input.forces[j - 6] + h,
            Some((_, h)) => input.duration = input.duration.map(|duration| duration + h),
            None => {}
        }
        input
    }

    /// The tangent of the increment from rest; nothing within a hair of the threshold, where there are two.
    fn tangent_sheet(&self) -> Option<Sheet> {
        const HAIR: f64 = 1e-6;
        let friction = self.friction();
        let (outcome, tangent) =
            friction.tangent(&State::<f64>::default(), &self.input(None), Branch::Decided);
        if outcome.trial.abs() <= HAIR * outcome.limit.abs() {
            return None;
        }
        let partials = |tangent: &crate::behavior::friction::Tangent<f64>| -> Vec<Partial<f64>> {
            let mut all = tangent.force.to_vec();
            all.extend([tangent.slip_increment, tangent.normal, tangent.limit]);
            all
        };
        let flat = |partial: &Partial<f64>| -> Vec<f64> {
            partial.displacement.iter().chain(&partial.forces).chain([&partial.duration]).copied().collect()
        };
        let results = |input: &Input<'_, Wide>| -> [Wide; 9] {
            let outcome = friction.update(&State::default(), input, Branch::Decided);
            let [f1, f2, f3, m1, m2, m3] = outcome.force;
            [f1, f2, f3, m1, m2, m3, outcome.slip_increment, outcome.normal, outcome.limit]
        };
        let names: Vec<String> =
            FORCE.iter().map(ToString::to_string).chain(["Δγ", "F_N", "limit"].map(String::from)).collect();
        let inputs: Vec<String> = COMPONENT
            .iter()
            .map(|name| format!("Δ{name}"))
            .chain(FORCE.iter().map(ToString::to_string))
            .chain(["Δt".to_string()])
            .collect();
        let sizes = self.input_sizes(outcome.limit);
        let still = results(&self.input(None));
        let step = |j: usize, by: f64| Wide::from_f64(by * sizes[j]);
        let slopes: [[Wide; 9]; 13] = std::array::from_fn(|j| {
            let h = step(j, FIRST_STEP);
            let [plus, minus] = [h, -h].map(|h| results(&self.input(Some((j, h)))));
            std::array::from_fn(|i| (plus[i] - minus[i]) / (h + h))
        });
        // How slopes change, for the bound: by differences of tangents on 237 bits.
        let wide = |moved: (usize, Wide)| {
            let (_, tangent) = friction.tangent(&State::default(), &self.input(Some(moved)), Branch::Decided);
            let mut all = tangent.force.to_vec();
            all.extend([tangent.slip_increment, tangent.normal, tangent.limit]);
            all
        };
        let mut bent = [[0.0_f64; 13]; 9];
        for l in 0..13 {
            let h = step(l, FIRST_STEP);
            let (plus, minus) = (wide((l, h)), wide((l, -h)));
            for (i, (plus, minus)) in plus.iter().zip(&minus).enumerate() {
                let pairs = plus.displacement.iter().chain(&plus.forces).chain([&plus.duration]);
                let others = minus.displacement.iter().chain(&minus.forces).chain([&minus.duration]);
                for (j, (p, m)) in pairs.zip(others).enumerate() {
                    bent[i][j] += ((*p - *m) / (h + h)).to_f64().abs() * sizes[l];
                }
            }
        }
        let got = partials(&tangent);
        let mut sheet = Sheet::new(Quantity::FrictionTangent);
        sheet.rows = names.iter().map(|name| format!("∂{name}")).collect();
        sheet.columns = inputs;
        // Kinds of results and inputs, numbers of one kind having one unit.
        let kind = |i: usize| if i < 6 { i / 3 } else { i };
        let kind_of_input = |j: usize| j / 3;
        for (i, partial) in got.iter().enumerate() {
            // The forces share what they are returned from: each is as uncertain as the largest of its kind.
            let alike = (0..names.len()).filter(|other| kind(*other) == kind(i));
            let size = |i: usize| {
                still[i].to_f64().abs() + (0..13).map(|j| slopes[j][i].to_f64().abs() * sizes[j]).sum::<f64>()
            };
            let f = alike.map(size).fold(0.0, f64::max);
            for (j, got) in flat(partial).into_iter().enumerate() {
                sheet.entries.push(Entry {
                    name: format!("∂{}/∂{}", names[i], sheet.columns[j]),
                    got,
                    want: slopes[j][i],
                    scale: f / sizes[j] + bent[i][j],
                    class: (kind(i), kind_of_input(j), 0),
                });
            }
        }
        let mut other = |mistake, wrong: Vec<Partial<f64>>| {
            let changes = wrong.iter().flat_map(flat).enumerate().collect();
            sheet.mistakes.push(Change { mistake, changes });
        };
        let branch = if outcome.status == Status::Slip { Branch::Stick } else { Branch::Slip };
        let (_, wrong) = friction.tangent(&State::default(), &self.input(None), branch);
        other(Mistake::StickForSlip, partials(&wrong));
        let uncoupled = got.iter().map(|partial| Partial { forces: [0.0; 6], ..*partial }).collect();
        other(Mistake::CouplingMissing, uncoupled);
        for (mistake, criterion) in self.criterion.factor_mistakes() {
            let friction = Friction { criterion, ..friction.clone() };
            let (_, wrong) = friction.tangent(&State::default(), &self.input(None), Branch::Decided);
            other(Mistake::from(mistake), partials(&wrong));
        }
        Some(sheet)
    }
}

impl From<FactorMistake> for Mistake {
    fn from(mistake: FactorMistake) -> Self {
        match mistake {
            FactorMistake::NumberLeftOut => Self::NumberLeftOut,
            FactorMistake::Multiplied => Self::MultipliedInsteadOfDivided,
        }
    }
}
