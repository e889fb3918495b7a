//! The keywords that are understood: where they may stand, and which parameters they take.

pub(super) mod beginnings;

use crate::behavior::{
    Basis, DamageCriterion, DamageEvolutionKind, DampingKind, Degradation, Extrapolation,
    HardeningDefinition, HardeningKind, Integration, Operator, PotentialOperator, RateInterpolation,
    Softening,
};
use crate::choice::Choice;
use crate::deck::{Deck, assembly, behavior, connector, constraint, generate, history, mesh, unread};
use crate::diagnostic::{Code, Diagnostic, Result, nearest, suggest};
use crate::lexer::{Keyword, KeywordParameter, Value};
use crate::model::Weighting;
use crate::model::{AmplitudeTime, AmplitudeValue, DefaultAmplitude, MotionType, Operation, TransformKind};
use std::collections::HashSet;

/// Where a keyword may stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    /// Before the first step.
    Model,
    /// Within a step.
    History,
    /// Before the first step or within a step.
    Both,
    /// It opens or closes a step itself.
    Step,
}

/// Does a keyword belong to the connector behaviour above it?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
    /// It stands alone.
    Plain,
    /// It belongs to `*CONNECTOR BEHAVIOR`.
    Suboption,
}

/// What becomes of a parameter that a keyword is not known to have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Strange {
    /// It is an error: the keyword bears on connectors.
    Refused,
    /// It is skipped, for no connector depends on it.
    Skipped,
    /// It is skipped unless it looks misspelt.
    Unlike,
    /// The keyword is skipped with its lines, unless they name a node of a connector or constraint.
    ByNodes,
}

/// What a parameter takes after its equals sign.
#[derive(Debug, Clone, Copy)]
pub(super) enum Takes {
    /// Nothing.
    Flag,
    /// A name.
    Name,
    /// Anything.
    Text,
    /// A number.
    Number,
    /// A whole number.
    Count,
    /// A component, 1 to 6.
    Component,
    /// One of these.
    One(&'static [&'static str]),
    /// Nothing, or one of these.
    FlagOr(&'static [&'static str]),
    /// Nothing, or anything.
    FlagOrText,
}

/// A parameter that a keyword takes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parameter {
    pub(super) name: &'static str,
    takes: Takes,
    needed: bool,
    /// Is its value in the scene?
    kept: bool,
}

/// A keyword that is understood.
#[derive(Debug)]
pub(super) struct Rule {
    pub(super) name: &'static str,
    pub(super) stage: Stage,
    pub(super) family: Family,
    /// None: every parameter is kept as it is.
    pub(super) parameters: Option<&'static [Parameter]>,
    /// What becomes of a parameter that is not listed.
    pub(super) strange: Strange,
    /// What its data lines are, for messages.
    pub(super) data: &'static str,
    pub(super) read: fn(&mut Deck<'_>, &Keyword) -> Result<()>,
}

const fn may(name: &'static str, takes: Takes) -> Parameter {
    Parameter { name, takes, needed: false, kept: true }
}

/// A parameter that is checked, and not kept.
const fn pass(name: &'static str, takes: Takes) -> Parameter {
    Parameter { name, takes, needed: false, kept: false }
}

const fn need(name: &'static str, takes: Takes) -> Parameter {
    Parameter { name, takes, needed: true, kept: true }
}

const fn rule(
    name: &'static str,
    stage: Stage,
    parameters: &'static [Parameter],
    data: &'static str,
    read: fn(&mut Deck<'_>, &Keyword) -> Result<()>,
) -> Rule {
    Rule {
        name,
        stage,
        family: Family::Plain,
        parameters: Some(parameters),
        strange: Strange::Refused,
        data,
        read,
    }
}

const fn suboption(
    name: &'static str,
    parameters: &'static [Parameter],
    data: &'static str,
    read: fn(&mut Deck<'_>, &Keyword) -> Result<()>,
) -> Rule {
    Rule {
        name,
        stage: Model,
        family: Family::Suboption,
        parameters: Some(parameters),
        strange: Strange::Refused,
        data,
        read,
    }
}

impl Rule {
    /// The same, where parameters that are not listed are no error.
    const fn with_strange(self, strange: Strange) -> Self {
        Self { strange, ..self }
    }
}

const fn output(name: &'static str) -> Rule {
    Rule {
        name,
        stage: History,
        family: Family::Plain,
        parameters: None,
        strange: Strange::Skipped,
        data: "it takes output identifiers",
        read: history::output,
    }
}

use Stage::{Both, History, Model};
use Takes::{Component, Count, Flag, FlagOr, FlagOrText, Name, Number, One, Text};

const ON_OFF: Takes = One(&["ON", "OFF"]);
const EXTRAPOLATION: Parameter = may("EXTRAPOLATION", One(Extrapolation::SPELLINGS));
const REGULARIZE: Parameter = may("REGULARIZE", ON_OFF);
const RTOL: Parameter = may("RTOL", Number);
const DEPENDENCIES: Parameter = may("DEPENDENCIES", Count);
const INDEPENDENT_COMPONENTS: Parameter = may("INDEPENDENT COMPONENTS", One(Basis::SPELLINGS));
const COMPONENT: Parameter = may("COMPONENT", Component);
const AMPLITUDE: Parameter = may("AMPLITUDE", Name);
const OPERATION: Parameter = may("OP", One(Operation::SPELLINGS));
const LOAD_CASE: Parameter = may("LOAD CASE", Count);
const MOTION_TYPE: Parameter = may("TYPE", One(MotionType::SPELLINGS));

/// Every keyword that is understood.
pub(super) static RULES: &[Rule] = &[
    rule("HEADING", Model, &[pass("SPARSE", Flag)], "it takes lines of text", mesh::heading)
        .with_strange(Strange::Skipped),
    rule(
        "NODE",
        Model,
        &[may("NSET", Name), may("SYSTEM", One(&["R", "C", "S"])), may("INPUT", Text)],
        "each line is: node, x, y, z",
        mesh::node,
    )
    .with_strange(Strange::Unlike),
    rule(
        "NSET",
        Both,
        &[
            need("NSET", Name),
            may("ELSET", Name),
            may("GENERATE", Flag),
            may("INSTANCE", Name),
            pass("INTERNAL", Flag),
            may("UNSORTED", Flag),
        ],
        "each line lists nodes or node sets; with GENERATE: first, last, increment",
        mesh::node_set,
    )
    .with_strange(Strange::Unlike),
    rule(
        "ELSET",
        Both,
        &[
            need("ELSET", Name),
            may("GENERATE", Flag),
            may("INSTANCE", Name),
            pass("INTERNAL", Flag),
            may("UNSORTED", Flag),
        ],
        "each line lists elements or element sets; with GENERATE: first, last, increment",
        mesh::element_set,
    )
    .with_strange(Strange::Unlike),
    rule(
        "ELEMENT",
        Model,
        &[
            need("TYPE", Text),
            may("ELSET", Name),
            may("INPUT", Text),
            // Of a substructure.
            pass("FILE", Text),
            pass("OFFSET", Count),
            pass("SOLID ELEMENT NUMBERING", Text),
        ],
        "each line is: element, node, node …",
        mesh::element,
    )
    .with_strange(Strange::Unlike),
    rule(
        "NGEN",
        Model,
        &[may("NSET", Name), may("LINE", One(&["P", "C"])), may("SYSTEM", One(&["RC", "C", "S"]))],
        "each line is: first node, last node, increment; on a curve also a further node or point, and a normal",
        generate::nodes,
    ),
    rule(
        "ELGEN",
        Model,
        &[may("ELSET", Name)],
        "each line is: element, number, node increment, element increment, and again for rows and layers",
        generate::elements,
    ),
    rule(
        "NFILL",
        Model,
        &[may("NSET", Name), may("BIAS", Number), may("TWO STEP", Flag), may("SINGULAR", Count)],
        "each line is: first node set, last node set, number of intervals, increment",
        generate::copy::fill,
    ),
    rule(
        "NCOPY",
        Model,
        &[
            need("CHANGE NUMBER", Count),
            need("OLD SET", Name),
            may("NEW SET", Name),
            may("MULTIPLE", Count),
            may("SHIFT", Flag),
            may("REFLECT", One(&["LINE", "MIRROR", "POINT"])),
            may("POLE", Flag),
        ],
        "its lines give a shift and a rotation, or the points that define the reflection, or the pole",
        generate::copy::nodes,
    ),
    rule(
        "ELCOPY",
        Model,
        &[
            need("ELEMENT SHIFT", Count),
            need("OLD SET", Name),
            need("SHIFT NODES", Count),
            may("NEW SET", Name),
            pass("REFLECT", FlagOrText),
        ],
        "it takes no data lines",
        generate::copy::elements,
    ),
    rule("SYSTEM", Model, &[], "line 1 gives points a and b, line 2 point c", mesh::system),
    rule(
        "NMAP",
        Model,
        &[need("NSET", Name), may("TYPE", Text)],
        "its lines give the mapping",
        unread::mapping,
    )
    .with_strange(Strange::Skipped),
    rule("PART", Model, &[need("NAME", Name)], "it takes no data lines", assembly::part),
    rule("END PART", Model, &[], "it takes no data lines", assembly::end_part),
    rule("ASSEMBLY", Model, &[may("NAME", Name)], "it takes no data lines", assembly::assembly),
    rule("END ASSEMBLY", Model, &[], "it takes no data lines", assembly::end_assembly),
    rule(
        "INSTANCE",
        Model,
        &[may("NAME", Name), may("PART", Name), may("LIBRARY", Text), may("INSTANCE", Name)],
        "line 1 is a translation, line 2: two points of an axis, and an angle in degrees",
        assembly::instance,
    ),
    rule("END INSTANCE", Model, &[], "it takes no data lines", assembly::end_instance),
    rule(
        "ORIENTATION",
        Model,
        &[
            need("NAME", Name),
            may(
                "SYSTEM",
                One(&[
                    "RECTANGULAR",
                    "Z RECTANGULAR",
                    "CYLINDRICAL",
                    "SPHERICAL",
                    "USER",
                    "R",
                    "Z",
                    "C",
                    "S",
                ]),
            ),
            may("DEFINITION", One(&["COORDINATES", "NODES", "OFFSET TO NODES"])),
            pass("LOCAL DIRECTIONS", Count),
        ],
        "line 1 gives the points a, b, c; line 2: axis, additional rotation in degrees",
        mesh::orientation,
    ),
    rule(
        "TRANSFORM",
        Model,
        &[need("NSET", Name), may("TYPE", One(TransformKind::SPELLINGS))],
        "one line: Xa, Ya, Za, Xb, Yb, Zb",
        mesh::transform,
    ),
    rule(
        "MASS",
        Model,
        &[
            need("ELSET", Name),
            may("TYPE", One(&["ISOTROPIC", "ANISOTROPIC"])),
            pass("ALPHA", Number),
            pass("COMPOSITE", Number),
            pass("ORIENTATION", Name),
        ],
        "one line: the mass",
        mesh::mass,
    ),
    rule(
        "ROTARY INERTIA",
        Model,
        &[need("ELSET", Name), may("ORIENTATION", Name), pass("ALPHA", Number), pass("COMPOSITE", Number)],
        "one line: I11, I22, I33, I12, I13, I23",
        mesh::rotary_inertia,
    ),
    rule(
        "SPRING",
        Model,
        &[
            need("ELSET", Name),
            may("NONLINEAR", Flag),
            may("ORIENTATION", Name),
            may("COMPLEX STIFFNESS", Flag),
            DEPENDENCIES,
            pass("EXTRAPOLATION", Text),
            pass("REGULARIZE", ON_OFF),
            pass("RTOL", Number),
        ],
        "line 1 gives the degrees of freedom, the next ones the stiffness",
        mesh::spring,
    ),
    rule(
        "DASHPOT",
        Model,
        &[
            need("ELSET", Name),
            may("NONLINEAR", Flag),
            may("ORIENTATION", Name),
            DEPENDENCIES,
            pass("EXTRAPOLATION", Text),
            pass("REGULARIZE", ON_OFF),
            pass("RTOL", Number),
        ],
        "line 1 gives the degrees of freedom, the next ones the coefficient",
        mesh::dashpot,
    ),
    rule(
        "MPC",
        Model,
        &[may("USER", Flag), pass("MODE", One(&["DOF", "NODE"])), may("INPUT", Text)],
        "each line is: type, node, node …",
        connector::mpc,
    ),
    rule(
        "EQUATION",
        Both,
        &[may("INPUT", Text), may("REMOVE", FlagOrText)],
        "a line with the number of terms, then the terms: node, degree of freedom, factor",
        constraint::equation,
    )
    .with_strange(Strange::Skipped),
    rule(
        "SURFACE",
        Model,
        &[need("NAME", Name), may("TYPE", Text), may("COMBINE", Text), may("CROP", Text)],
        "each line of TYPE=NODE is: node or node set, area",
        constraint::surface,
    )
    .with_strange(Strange::Skipped),
    rule(
        "RIGID BODY",
        Model,
        &[
            may("REF NODE", Name),
            may("ELSET", Name),
            may("PIN NSET", Name),
            may("TIE NSET", Name),
            may("NSET", Name),
            may("ROT NODE", Name),
            may("ANALYTICAL SURFACE", Name),
            may("POSITION", One(&["INPUT", "CENTER OF MASS"])),
        ],
        "it takes a thickness",
        constraint::rigid_body,
    )
    .with_strange(Strange::Skipped),
    rule(
        "COUPLING",
        Model,
        &[
            may("CONSTRAINT NAME", Name),
            may("REF NODE", Name),
            may("SURFACE", Name),
            may("ORIENTATION", Name),
            may("INFLUENCE RADIUS", Number),
        ],
        "*KINEMATIC or *DISTRIBUTING follows it",
        constraint::coupling,
    )
    .with_strange(Strange::Skipped),
    rule(
        "KINEMATIC COUPLING",
        Model,
        &[may("REF NODE", Name), may("ORIENTATION", Name)],
        "each line is: node or node set, first, last degree of freedom",
        constraint::kinematic_coupling,
    )
    .with_strange(Strange::Skipped),
    rule(
        "DISTRIBUTING COUPLING",
        Model,
        &[need("ELSET", Name)],
        "each line is: node or node set, weight",
        constraint::distributing_coupling,
    )
    .with_strange(Strange::Skipped),
    rule("KINEMATIC", Model, &[], "each line is: first, last degree of freedom", constraint::kinematic)
        .with_strange(Strange::Skipped),
    rule(
        "DISTRIBUTING",
        Model,
        &[
            may("COUPLING", One(&["CONTINUUM", "STRUCTURAL"])),
            may("WEIGHTING METHOD", One(Weighting::SPELLINGS)),
            may("CYCLIC SYMMETRY", FlagOrText),
        ],
        "each line is: first, last degree of freedom",
        constraint::distributing,
    )
    .with_strange(Strange::Skipped),
    rule(
        "TIE",
        Model,
        &[
            may("NAME", Name),
            may("POSITION TOLERANCE", Number),
            may("TYPE", Text),
            may("NO ROTATION", Flag),
            may("CYCLIC SYMMETRY", FlagOrText),
            may("CONSTRAINT RATIO", Text),
            may("MULTIPHYSICS", Text),
            may("FLUID PERIODIC", Text),
        ],
        "each line is: dependent surface, other surface",
        constraint::tie,
    )
    .with_strange(Strange::Skipped),
    rule(
        "CONNECTOR SECTION",
        Model,
        &[
            need("ELSET", Name),
            may("BEHAVIOR", Name),
            may("CONTROLS", Name),
            may("ELIMINATION", One(&["NO", "YES"])),
        ],
        "its lines are: connection types; orientations; section data",
        connector::section,
    ),
    rule(
        "CONNECTOR BEHAVIOR",
        Model,
        &[
            need("NAME", Name),
            EXTRAPOLATION,
            may("INTEGRATION", One(Integration::SPELLINGS)),
            REGULARIZE,
            RTOL,
        ],
        "it takes no data lines; suboptions follow",
        behavior::behavior,
    ),
    suboption(
        "CONNECTOR CONSTITUTIVE REFERENCE",
        &[],
        "one line: l1, l2, l3, then three angles in degrees",
        behavior::constitutive_reference,
    ),
    suboption(
        "CONNECTOR ELASTICITY",
        &[
            COMPONENT,
            may("NONLINEAR", Flag),
            may("RIGID", Flag),
            may("UNSYMM", Flag),
            may("FREQUENCY DEPENDENCE", FlagOr(&["ON", "OFF"])),
            INDEPENDENT_COMPONENTS,
            DEPENDENCIES,
            EXTRAPOLATION,
            REGULARIZE,
            RTOL,
        ],
        "each line is: stiffness, frequency, temperature; nonlinear: force, displacement, temperature",
        behavior::elasticity,
    ),
    suboption(
        "CONNECTOR DAMPING",
        &[
            COMPONENT,
            may("NONLINEAR", Flag),
            may("TYPE", One(DampingKind::SPELLINGS)),
            may("UNSYMM", Flag),
            may("FREQUENCY DEPENDENCE", FlagOr(&["ON", "OFF"])),
            INDEPENDENT_COMPONENTS,
            DEPENDENCIES,
            EXTRAPOLATION,
            REGULARIZE,
            RTOL,
        ],
        "each line is: coefficient, frequency, temperature; nonlinear: force, velocity, temperature",
        behavior::damping,
    ),
    suboption(
        "CONNECTOR FRICTION",
        &[
            may("PREDEFINED", Flag),
            COMPONENT,
            may("CONTACT FORCE", Text),
            may("STICK STIFFNESS", Number),
            INDEPENDENT_COMPONENTS,
            DEPENDENCIES,
            EXTRAPOLATION,
            REGULARIZE,
            RTOL,
        ],
        "predefined: one line of constants; otherwise a table of internal contact forces",
        behavior::friction,
    ),
    suboption(
        "FRICTION",
        &[
            may("EXPONENTIAL DECAY", Flag),
            may("TAUMAX", Number),
            may("SLIP TOLERANCE", Number),
            may("ELASTIC SLIP", Number),
            may("TEST DATA", Flag),
            DEPENDENCIES,
        ],
        "each line is: μ, slip rate, contact force, temperature",
        behavior::friction_coefficient,
    ),
    suboption(
        "CONNECTOR DERIVED COMPONENT",
        &[
            need("NAME", Name),
            may("OPERATOR", One(Operator::SPELLINGS)),
            may("SIGN", One(&["POSITIVE", "NEGATIVE"])),
            INDEPENDENT_COMPONENTS,
            DEPENDENCIES,
            EXTRAPOLATION,
            REGULARIZE,
            RTOL,
        ],
        "line 1 lists components; the next ones scale factors",
        behavior::derived_component,
    ),
    suboption(
        "CONNECTOR POTENTIAL",
        &[may("OPERATOR", One(PotentialOperator::SPELLINGS)), may("EXPONENT", Number)],
        "each line is: component or derived component, R, α, H, shift, sign",
        behavior::potential,
    ),
    suboption("CONNECTOR PLASTICITY", &[COMPONENT], "it takes no data lines", behavior::plasticity),
    suboption(
        "CONNECTOR HARDENING",
        &[
            may("TYPE", One(HardeningKind::SPELLINGS)),
            may("DEFINITION", One(HardeningDefinition::SPELLINGS)),
            may("RATE FILTER FACTOR", Number),
            may("RATE INTERPOLATION", One(RateInterpolation::SPELLINGS)),
            DEPENDENCIES,
            EXTRAPOLATION,
            REGULARIZE,
            RTOL,
        ],
        "each line is a row of the table that DEFINITION names",
        behavior::hardening,
    ),
    suboption(
        "CONNECTOR DAMAGE INITIATION",
        &[
            COMPONENT,
            may("CRITERION", One(DamageCriterion::SPELLINGS)),
            may("RATE FILTER FACTOR", Number),
            may("RATE INTERPOLATION", One(RateInterpolation::SPELLINGS)),
            DEPENDENCIES,
            EXTRAPOLATION,
            REGULARIZE,
            RTOL,
        ],
        "each line is: lower limit, upper limit, temperature",
        behavior::damage_initiation,
    ),
    suboption(
        "CONNECTOR DAMAGE EVOLUTION",
        &[
            may("TYPE", One(DamageEvolutionKind::SPELLINGS)),
            may("SOFTENING", One(Softening::SPELLINGS)),
            may("DEGRADATION", One(Degradation::SPELLINGS)),
            may("AFFECTED COMPONENTS", Flag),
            DEPENDENCIES,
            EXTRAPOLATION,
            REGULARIZE,
            RTOL,
        ],
        "the affected components if announced, then the table",
        behavior::damage_evolution,
    ),
    suboption(
        "CONNECTOR STOP",
        &[need("COMPONENT", Component)],
        "one line: lower, upper position",
        behavior::stop,
    ),
    suboption(
        "CONNECTOR LOCK",
        &[need("COMPONENT", Component), may("LOCK", Text), DEPENDENCIES, EXTRAPOLATION, REGULARIZE, RTOL],
        "each line is: lower, upper position, lower, upper force",
        behavior::lock,
    ),
    suboption(
        "CONNECTOR FAILURE",
        &[need("COMPONENT", Component), may("RELEASE", Text)],
        "one line: lower, upper position, lower, upper force",
        behavior::failure,
    ),
    rule(
        "CONNECTOR MOTION",
        Both,
        &[
            MOTION_TYPE,
            AMPLITUDE,
            OPERATION,
            LOAD_CASE,
            may("FIXED", Flag),
            may("USER", Flag),
            may("REAL", Flag),
            may("IMAGINARY", Flag),
        ],
        "each line is: element or element set, component, magnitude",
        history::connector_motion,
    ),
    rule(
        "CONNECTOR LOAD",
        History,
        &[AMPLITUDE, OPERATION, LOAD_CASE, may("REAL", Flag), may("IMAGINARY", Flag)],
        "each line is: element or element set, component, magnitude",
        history::connector_load,
    ),
    rule(
        "BOUNDARY",
        Both,
        &[
            MOTION_TYPE,
            AMPLITUDE,
            OPERATION,
            LOAD_CASE,
            may("FIXED", Flag),
            may("USER", Flag),
            pass("REAL", Flag),
            may("IMAGINARY", Flag),
            pass("REGION TYPE", Text),
        ],
        "each line is: node or node set, first, last degree of freedom, magnitude",
        history::boundary,
    )
    .with_strange(Strange::ByNodes),
    rule(
        "INITIAL CONDITIONS",
        Model,
        &[may("TYPE", Text)],
        "each line is: node or node set, degree of freedom, velocity",
        history::initial_conditions,
    )
    .with_strange(Strange::Skipped),
    rule(
        "CLOAD",
        History,
        &[
            AMPLITUDE,
            OPERATION,
            LOAD_CASE,
            may("FOLLOWER", Flag),
            may("REAL", Flag),
            may("IMAGINARY", Flag),
            pass("REGION TYPE", Text),
        ],
        "each line is: node or node set, degree of freedom, magnitude",
        history::concentrated_load,
    )
    .with_strange(Strange::ByNodes),
    rule(
        "DLOAD",
        History,
        &[
            AMPLITUDE,
            OPERATION,
            LOAD_CASE,
            may("FOLLOWER", FlagOr(&["YES", "NO"])),
            may("REAL", Flag),
            may("IMAGINARY", Flag),
        ],
        "each line is: element or element set, label, magnitude …",
        history::distributed_load,
    )
    .with_strange(Strange::Skipped),
    rule(
        "AMPLITUDE",
        Both,
        &[
            need("NAME", Name),
            may("DEFINITION", Text),
            may("INPUT", Text),
            may("TIME", One(AmplitudeTime::SPELLINGS)),
            may("VALUE", One(AmplitudeValue::SPELLINGS)),
            may("SMOOTH", Number),
            may("FIXED INTERVAL", Number),
            may("BEGIN", Number),
        ],
        "its lines are: time, value, time, value …",
        history::amplitude,
    )
    .with_strange(Strange::Unlike),
    rule(
        "STEP",
        Stage::Step,
        &[
            may("NAME", Name),
            may("NLGEOM", FlagOr(&["YES", "NO"])),
            may("INC", Count),
            // Of CalculiX, for fluids.
            pass("INCF", Count),
            may("PERTURBATION", Flag),
            may("AMPLITUDE", One(DefaultAmplitude::SPELLINGS)),
            pass("UNSYMM", One(&["YES", "NO"])),
            pass("EXTRAPOLATION", Text),
            pass("CONVERT SDI", One(&["YES", "NO"])),
            pass("SOLVER", Text),
        ],
        "it takes lines of text",
        history::step,
    )
    .with_strange(Strange::Skipped),
    rule("END STEP", Stage::Step, &[], "it takes no data lines", history::end_step)
        .with_strange(Strange::Skipped),
    rule(
        "STATIC",
        History,
        &[
            pass("DIRECT", FlagOrText),
            pass("STABILIZE", FlagOrText),
            pass("ALLSDTOL", FlagOrText),
            pass("CONTINUE", Text),
            pass("FACTOR", Number),
            pass("RIKS", Flag),
            pass("ADIABATIC", Flag),
            pass("FULLY PLASTIC", Text),
            pass("LONG TERM", Flag),
        ],
        "one line: initial, total, minimum, maximum time",
        history::static_procedure,
    )
    .with_strange(Strange::Skipped),
    rule(
        "DYNAMIC",
        History,
        &[
            may("EXPLICIT", Flag),
            pass("ALPHA", Number),
            pass("APPLICATION", Text),
            pass("BETA", Number),
            pass("GAMMA", Number),
            pass("DIRECT", FlagOrText),
            pass("HAFTOL", Number),
            pass("HALFINC SCALE FACTOR", Number),
            pass("INITIAL", Text),
            pass("NOHAF", Flag),
            pass("ADIABATIC", Flag),
            pass("TIME INTEGRATOR", Text),
            pass("IMPACT", Text),
            pass("SINGULAR MASS", Text),
            pass("ELEMENT BY ELEMENT", Flag),
            pass("SCALE FACTOR", Number),
            pass("FIXED TIME INCREMENTATION", Flag),
            pass("DIRECT USER CONTROL", Flag),
        ],
        "one line: initial, total, minimum, maximum time",
        history::dynamic,
    )
    .with_strange(Strange::Skipped),
    output("OUTPUT"),
    output("ELEMENT OUTPUT"),
    output("NODE OUTPUT"),
    output("ENERGY OUTPUT"),
    output("INCREMENTATION OUTPUT"),
    output("CONTACT OUTPUT"),
];

/// The rule of a keyword; blanks inside it do not matter.
pub(super) fn find(name: &str) -> Option<&'static Rule> {
    let same = |rule: &&Rule| {
        rule.name.bytes().filter(|&byte| byte != b' ').eq(name.bytes().filter(|&byte| byte != b' '))
    };
    RULES.iter().find(same)
}

/// The one keyword of several words of which each begins so, as `CONN ELAS`. Requests of output are not meant.
pub(super) fn shortened(name: &str) -> Option<&'static str> {
    let begins = |known: &&str| {
        let words = || known.split_ascii_whitespace();
        let given = name.split_ascii_whitespace();
        words().count() == given.clone().count()
            && words().zip(given).all(|(word, part)| word.starts_with(part))
    };
    let all = RULES.iter().filter(|rule| rule.parameters.is_some()).map(|rule| rule.name);
    let mut all = all.filter(begins);
    let found = all.next().filter(|_| name.contains(' '))?;
    all.next().is_none().then_some(found)
}

/// Whether each data line of a keyword stands for itself, so that reading goes on after a faulty one.
pub(super) fn reads_by_line(name: &str) -> bool {
    matches!(
        name,
        "NODE"
            | "NGEN"
            | "NFILL"
            | "NSET"
            | "ELSET"
            | "ELEMENT"
            | "ELGEN"
            | "MPC"
            | "CONNECTOR MOTION"
            | "CONNECTOR LOAD"
            | "BOUNDARY"
            | "CLOAD"
            | "DLOAD"
            | "INITIAL CONDITIONS"
    )
}

/// The keywords of output requests.
pub(super) fn outputs() -> impl Iterator<Item = &'static str> {
    RULES.iter().filter(|rule| rule.parameters.is_none()).map(|rule| rule.name)
}

/// Is it a keyword of output requests?
pub(super) fn is_output(name: &str) -> bool {
    outputs().any(|output| output == name)
}

/// Does a keyword begin or end a part, an instance or the assembly?
pub(super) fn is_of_assembly(name: &str) -> bool {
    matches!(name, "PART" | "END PART" | "ASSEMBLY" | "END ASSEMBLY" | "INSTANCE" | "END INSTANCE")
}

/// Does a keyword define what belongs to a part, an instance or the assembly, where a deck has these?
pub(super) fn is_of_level(name: &str) -> bool {
    matches!(
        name,
        "NODE"
            | "NSET"
            | "NGEN"
            | "NFILL"
            | "NCOPY"
            | "NMAP"
            | "SYSTEM"
            | "ELCOPY"
            | "ELEMENT"
            | "ELSET"
            | "ELGEN"
            | "ORIENTATION"
            | "TRANSFORM"
            | "MASS"
            | "ROTARY INERTIA"
            | "SPRING"
            | "DASHPOT"
            | "MPC"
            | "CONNECTOR SECTION"
    )
}

/// Is it a constraint beside connectors, or what one is made of? It may stand in parts, in the assembly and outside them, and what it has
/// besides the parameters that are read does not refuse a deck.
pub(super) fn is_constraint(name: &str) -> bool {
    matches!(
        name,
        "EQUATION"
            | "SURFACE"
            | "RIGID BODY"
            | "COUPLING"
            | "KINEMATIC"
            | "KINEMATIC COUPLING"
            | "DISTRIBUTING COUPLING"
            | "DISTRIBUTING"
            | "TIE"
    )
}

/// Procedures that are noted but not read.
pub(super) fn is_procedure(name: &str) -> bool {
    [
        "ANNEAL",
        "BUCKLE",
        "COMPLEX FREQUENCY",
        "COUPLED TEMPERATURE-DISPLACEMENT",
        "COUPLED THERMAL-ELECTRICAL",
        "DIRECT CYCLIC",
        "DYNAMIC TEMPERATURE-DISPLACEMENT",
        "FREQUENCY",
        "GEOSTATIC",
        "HEAT TRANSFER",
        "MODAL DYNAMIC",
        "RANDOM RESPONSE",
        "RESPONSE SPECTRUM",
        "SOILS",
        "STEADY STATE DYNAMICS",
        "SUBSTRUCTURE GENERATE",
        "VISCO",
    ]
    .contains(&name)
}

/// Keywords that constrain nodes and are skipped. Suboptions, such as `*KINEMATIC` below `*COUPLING`, are of their keywords.
const CONSTRAINTS: [&str; 5] = [
    "CYCLIC SYMMETRY MODEL",
    "EMBEDDED ELEMENT",
    "FASTENER",
    "PRE-TENSION SECTION",
    "SHELL TO SOLID COUPLING",
];

/// The name of a keyword that constrains nodes and is skipped, if it is one.
pub(super) fn constraint(name: &str) -> Option<&'static str> {
    CONSTRAINTS.into_iter().find(|known| *known == name)
}

/// Curves below `*CONNECTOR UNIAXIAL BEHAVIOR`.
pub(super) fn is_curve(name: &str) -> bool {
    matches!(name, "LOADING DATA" | "UNLOADING DATA")
}

/// Keywords of the documentation that look like misspelt ones of ours.
pub(super) fn is_unrelated(name: &str) -> bool {
    is_procedure(name) || is_curve(name) || beginnings::is_other(name)
}

impl Rule {
    /// Is the keyword one of connectors or constraints?
    pub(super) fn bears(&self) -> bool {
        self.name.starts_with("CONNECTOR")
            || self.name == "MPC"
            || (is_constraint(self.name) && self.name != "SURFACE")
    }

    /// The parameters of a keyword that are not kept.
    pub(super) fn passed_over<'a>(&'a self, keyword: &'a Keyword) -> impl Iterator<Item = &'static str> + 'a {
        let passed = self.parameters.into_iter().flatten().filter(|parameter| !parameter.kept);
        passed.map(|parameter| parameter.name).filter(|name| keyword.has(name))
    }

    /// Does INPUT name a file whose lines stand for data lines?
    pub(super) fn takes_input(&self) -> bool {
        self.name != "AMPLITUDE"
            && self.parameters.is_some_and(|known| known.iter().any(|one| one.name == "INPUT"))
    }

    /// Gives parameters that are written by any unambiguous beginning their names. Every parameter must be given once and have the kind of
    /// value that it takes; those needed must be there. Gives the names of those that are not known where that is no error.
    pub(super) fn check_parameters(&self, keyword: &mut Keyword) -> Result<Vec<String>> {
        let mut errors = Vec::new();
        let mut strange = Vec::new();
        let mut seen = HashSet::new();
        if let Some(known) = self.parameters {
            let names: Vec<&str> = known.iter().map(|parameter| parameter.name).collect();
            keyword.complete(&names);
        }
        if self.strange == Strange::Skipped && !self.bears() {
            // What is kept says something of connectors, but for the number of increments; a word may be a name.
            let matters = |name: &str| {
                let known = self.parameters.into_iter().flatten().find(|known| known.name == name);
                known.is_some_and(|known| {
                    matches!(known.takes, Name | Text) || (known.kept && known.name != "INC")
                })
            };
            let is_open = |given: &KeywordParameter| {
                !matters(&given.name) && given.value.as_ref().is_some_and(Value::is_parameter)
            };
            let left: Vec<_> = keyword.parameters.extract_if(.., |given| is_open(given)).collect();
            strange.extend(left.into_iter().map(|given| given.name));
        }
        let keyword = &*keyword;
        let name = &keyword.name;
        for (index, given) in keyword.parameters.iter().enumerate() {
            if !seen.insert(given.name.as_str()) {
                let message = format!("{} stands twice on one *{name}", given.name);
                errors.push(
                    Diagnostic::error(Code::RepeatedParameter, given.span, message, "the second one")
                        .help("keep one of the two"),
                );
                continue;
            }
            let Some(known) = self.parameters else { continue };
            match known.iter().find(|parameter| parameter.name == given.name) {
                Some(parameter) => errors.extend(parameter.check(keyword, index).err()),
                None if self.lets_pass(&given.name) => strange.push(given.name.clone()),
                None => errors.push(self.unknown(keyword, index)),
            }
        }
        let needed = self.parameters.into_iter().flatten().filter(|parameter| parameter.needed);
        // A name that is not known may be meant for the one that is missing.
        let is_known = errors.iter().all(|error| error.code() != Code::UnknownParameter);
        let missing = needed.filter(|parameter| !keyword.has(parameter.name) && is_known);
        let missing: Vec<Diagnostic> = missing.map(|parameter| keyword.missing(parameter.name)).collect();
        match Diagnostic::joined(errors.into_iter().chain(missing)) {
            None => Ok(strange),
            Some(error) => Err(error),
        }
    }

    /// A parameter that is not known is no error where no connector depends on it, or where it looks like a word of its own.
    fn lets_pass(&self, given: &str) -> bool {
        match self.strange {
            Strange::Refused => false,
            Strange::Skipped => true,
            Strange::Unlike | Strange::ByNodes => self.meant(given).is_none(),
        }
    }

    /// The parameter that a name looks like.
    pub(super) fn meant(&self, given: &str) -> Option<&'static str> {
        nearest(given, self.parameters.into_iter().flatten().map(|parameter| parameter.name))
    }

    fn unknown(&self, keyword: &Keyword, index: usize) -> Diagnostic {
        let (name, given) = (&keyword.name, &keyword.parameters[index]);
        let known: Vec<&str> =
            self.parameters.into_iter().flatten().map(|parameter| parameter.name).collect();
        let remedy = suggest(&given.name, known.iter().copied(), || {
            if known.is_empty() {
                return "this keyword takes no parameters; is a comma too many at the end of the line above?"
                    .to_owned();
            }
            format!("*{name} takes {}", known.join(", "))
        });
        let message = format!("*{name} has no parameter {}", given.name);
        Diagnostic::error(Code::UnknownParameter, given.span, message, "not a parameter").help(remedy)
    }
}

impl Parameter {
    fn check(&self, keyword: &Keyword, index: usize) -> Result<()> {
        let given = &keyword.parameters[index];
        let bad = |label: &str, remedy: String| {
            let message = keyword.words().map(|keyword| format!("bad value of {} on {keyword}", self.name));
            Err(Diagnostic::error(Code::BadParameterValue, given.span, message, label).help(remedy))
        };
        let value = match &given.value {
            Some(value) if !value.text().is_empty() => value,
            absent => {
                let alone = matches!(self.takes, Flag | FlagOr(_) | FlagOrText);
                return match absent {
                    None if alone => Ok(()),
                    _ => {
                        bad("its value is missing", format!("write {}=…{}", self.name, self.takes.examples()))
                    }
                };
            }
        };
        match self.takes {
            Flag => bad("takes no value", format!("write {} alone", self.name)),
            Name => value.name().map(|_| ()),
            Text | FlagOrText => Ok(()),
            Number => value.number().map(|_| ()),
            Count => value.integer(self.name).map(|_| ()),
            Component => value.component().map(|_| ()),
            One(choices) | FlagOr(choices) => value.word(self.name, choices).map(|_| ()),
        }
    }
}

impl Takes {
    fn examples(self) -> String {
        match self {
            One(choices) | FlagOr(choices) => format!(" with one of {}", choices.join(", ")),
            Component => " with a component, 1 to 6".to_owned(),
            Number | Count => " with a number".to_owned(),
            _ => String::new(),
        }
    }
}
