//! Predefined friction, traced: Φ = P − μ F_N, its gradient and second derivatives.

use crate::derivative::Derivation;
use crate::graph::{Graph, Id};
use crate::input::{InputUnit, Inputs, Shape};
use crate::symbol::{Symbol, TraceError, extend};
use pintle_kinematics::catalog::{Contact, Friction};
use pintle_model::behavior::friction::{
    Belt, Coefficient, Context, Criterion, ParameterError, StickStiffness,
};

/// What of a friction criterion is reported, in order.
pub const POINT: [&str; 4] = ["P", "F_C", "F_N", "Φ"];

/// A criterion of predefined friction as expressions.
#[derive(Clone, Debug)]
pub struct FrictionModel {
    /// The expressions.
    pub graph: Graph,
    /// What they are formed from: forces (or tensions and the angle of wrap), angles, μ, the parameters of the data line.
    pub inputs: Inputs,
    /// The number of forces by which derivatives are taken: the first inputs.
    pub forces: usize,
    /// The names of those forces.
    pub names: Vec<&'static str>,
    /// P, F_C, F_N and Φ ([`POINT`]).
    pub point: [Id; 4],
    /// ∂Φ by the forces.
    pub gradient: Vec<Id>,
    /// ∂²Φ by two forces, rows one after the other.
    pub hessian: Vec<Id>,
}

/// Why a friction cannot be traced.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FrictionTraceError {
    /// A formula branches too often.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// The criterion cannot be formed.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

/// A double that stands for the i-th parameter while formulas are traced: any that data of the program do not hold.
fn stand_in(i: usize) -> f64 {
    f64::from_bits(0x3ff7_1e5a_c0de_0000 + 0x1357 * (i as u64 + 1))
}

/// The name of a symbol in programs.
fn identifier(symbol: &str) -> String {
    symbol.replace('^', "_").replace('κ', "kappa")
}

impl FrictionModel {
    /// Every criterion of a friction.
    ///
    /// # Errors
    /// [`FrictionTraceError`].
    pub fn of(friction: &Friction) -> Result<Vec<Self>, FrictionTraceError> {
        (0..friction.criteria.len())
            .map(|i| match friction.criteria.get(i).map(|criterion| criterion.contact) {
                Some(Contact::Belt) => Self::belt(),
                _ => Self::criterion(friction, i),
            })
            .collect()
    }

    fn criterion(friction: &Friction, which: usize) -> Result<Self, FrictionTraceError> {
        const FORCES: &str = "f1 f2 f3 m1 m2 m3";
        let mut inputs = Inputs::default();
        let forces = inputs.add(
            ["f", FORCES, "forces f1, f2, f3 and moments m1, m2, m3 of the components, internal"],
            Shape::List(6),
            InputUnit::ForceOrMoment,
        );
        let angles = ["angles", "α β", "positions of ur1 and ur2 (Cardan angles)"];
        let angles = inputs.add(angles, Shape::List(2), InputUnit::Angle);
        let coefficient = inputs.add(["mu", "μ", "coefficient of friction"], Shape::Scalar, InputUnit::None);
        let symbols =
            friction.parameters.iter().map(|parameter| (parameter.symbol, "parameter of the data line"));
        let constants = friction.constants.iter().map(|constant| (constant.symbol, constant.meaning));
        let mut groups = Vec::new();
        for (symbol, meaning) in symbols.chain(constants) {
            let words = [identifier(symbol), symbol.to_string(), meaning.to_string()];
            let [name, symbol, meaning] = &words;
            groups.push(inputs.add([name, symbol, meaning], Shape::Scalar, InputUnit::OfParameter));
        }
        let mut graph = Graph::default();
        let numbers: Vec<f64> = (0..groups.len()).map(stand_in).collect();
        let stand_ins: Vec<(f64, Id)> = numbers
            .iter()
            .zip(&groups)
            .map(|(number, group)| {
                (*number, graph.input(inputs.numbers(*group).first().copied().unwrap_or(0)))
            })
            .collect();
        let (parameters, constants) = numbers.split_at(friction.parameters.len());
        let parameters: Vec<Option<f64>> = parameters.iter().copied().map(Some).collect();
        let criteria = Criterion::predefined(friction, &parameters, constants, false)?;
        let criterion = criteria.get(which).ok_or(ParameterError::Belt)?;
        let (graph, point) = extend(graph, &stand_ins, || {
            let mut context = Context::default();
            (context.position[3], context.position[4]) = (inputs.entry(angles, 0), inputs.entry(angles, 1));
            let f = [0, 1, 2, 3, 4, 5].map(|k| inputs.entry(forces, k));
            let (point, _) = criterion.at::<Symbol>(&f, inputs.scalar(coefficient), None, &context);
            [point.tangential, point.contact, point.normal, point.criterion]
        })?;
        Ok(Self::differentiated(graph, inputs, FORCES, point))
    }

    fn belt() -> Result<Self, FrictionTraceError> {
        let mut inputs = Inputs::default();
        let words = ["tension", "T1 T2", "tensions of the segments before and after the ring"];
        let tension = inputs.add(words, Shape::List(2), InputUnit::Force);
        let angle = inputs.add(["wrap", "α", "angle of wrap"], Shape::Scalar, InputUnit::Angle);
        let coefficient = inputs.add(["mu", "μ", "coefficient of friction"], Shape::Scalar, InputUnit::None);
        let belt = Belt {
            coefficient: Coefficient::Constant(0.0),
            maximum: None,
            stick_stiffness: StickStiffness::Given(1.0),
        };
        let (graph, point) = extend(Graph::default(), &[], || {
            let tension = [inputs.entry(tension, 0), inputs.entry(tension, 1)];
            let (point, _) = belt.at::<Symbol>(tension, inputs.scalar(angle), inputs.scalar(coefficient));
            [point.tangential, point.contact, point.normal, point.criterion]
        })?;
        Ok(Self::differentiated(graph, inputs, "T1 T2 α", point))
    }

    fn differentiated(mut graph: Graph, inputs: Inputs, names: &'static str, point: [Id; 4]) -> Self {
        let names: Vec<&'static str> = names.split(' ').collect();
        let one = graph.integer(1);
        let mut along: Vec<Derivation> =
            (0..names.len() as u32).map(|number| Derivation::along([(number, one)])).collect();
        let mut gradient_of =
            |id: Id| along.iter_mut().map(|derivation| derivation.of(&mut graph, id)).collect::<Vec<Id>>();
        let gradient = gradient_of(point[3]);
        let hessian = gradient.iter().flat_map(|entry| gradient_of(*entry)).collect();
        Self { graph, inputs, forces: names.len(), names, point, gradient, hessian }
    }
}
