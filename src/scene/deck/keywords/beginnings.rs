//! Keywords that are written by their beginning: `*BOUN` for `*BOUNDARY`.
//!
//! A beginning stands for a keyword where no other begins so, or where all others that do go on with its name, as `*ELEM` for `*ELEMENT` beside
//! `*ELEMENT OUTPUT`. Blanks do not count. The keywords of Abaqus that are not read count, too.

use crate::deck::keywords::RULES;

/// Keywords that are not read. Each is one that a beginning could mean besides a keyword that is read.
#[rustfmt::skip]
const OTHERS: &[&str] = &[
    "ACOUSTIC MEDIUM", "ADAPTIVE MESH", "ADJUST", "ANISOTROPIC HYPERELASTIC", "ANNEAL", "AQUA", "BASE MOTION", "BASELINE CORRECTION",
    "BEAM SECTION", "BEAM GENERAL SECTION", "BIAXIAL TEST DATA", "BLOCKAGE", "BOND", "BRITTLE CRACKING", "BUCKLE", "BUCKLING ENVELOPE",
    "BULK VISCOSITY", "C ADDED MASS", "CAP PLASTICITY", "CAPACITY", "CAST IRON PLASTICITY", "CAVITY DEFINITION", "CECHARGE", "CENTROID",
    "CFILM", "CFLOW", "CFLUX", "CHANGE FRICTION", "CLAY PLASTICITY", "CLEARANCE", "CO-SIMULATION", "COHESIVE BEHAVIOR", "COHESIVE SECTION",
    "COMBINED TEST DATA", "COMPLEX FREQUENCY", "COMPOSITE MODAL DAMPING", "CONCRETE", "CONDUCTIVITY", "CONNECTOR UNIAXIAL BEHAVIOR",
    "CONSTRAINT CONTROLS", "CONTACT", "CONTACT PAIR", "CONTACT OUTPUT", "CONTOUR INTEGRAL", "CONTROLS", "CORRELATION",
    "COUPLED TEMPERATURE-DISPLACEMENT", "COUPLED THERMAL-ELECTRICAL", "CRADIATE", "CREEP", "CRUSHABLE FOAM", "CYCLED PLASTIC", "CYCLIC",
    "CYCLIC HARDENING", "CYCLIC SYMMETRY MODEL", "D ADDED MASS", "DAMAGE EVOLUTION", "DAMAGE INITIATION", "DAMPING", "DEBOND",
    "DECHARGE", "DECURRENT", "DEFORMATION PLASTICITY", "DENSITY", "DEPVAR", "DESIGN PARAMETER", "DESIGN RESPONSE", "DETONATION POINT", "DFLOW",
    "DFLUX", "DIAGNOSTICS", "DIELECTRIC", "DIFFUSIVITY", "DIRECT CYCLIC", "DISPLAY BODY", "DISTRIBUTION", "DISTRIBUTION TABLE", "DRAG CHAIN",
    "DRUCKER PRAGER", "DSA CONTROLS", "DSECHARGE", "DSFLOW", "DSFLUX", "DSLOAD", "DYNAMIC TEMPERATURE-DISPLACEMENT", "EL FILE", "EL PRINT",
    "ELASTIC", "ELECTRICAL CONDUCTIVITY", "ELECTROMAGNETIC", "ELEMENT MATRIX OUTPUT", "ELEMENT RESPONSE", "EMBEDDED ELEMENT", "EMISSIVITY",
    "END LOAD CASE", "ENERGY FILE", "ENERGY PRINT", "ENRICHMENT", "EOS", "EPJOINT", "EULERIAN BOUNDARY", "EULERIAN SECTION", "EXPANSION",
    "EXTERNAL FIELD", "EXTREME VALUE", "FABRIC", "FAIL STRAIN", "FAIL STRESS", "FAILURE RATIOS", "FASTENER", "FASTENER PROPERTY", "FIELD",
    "FILE FORMAT", "FILE OUTPUT", "FILM", "FILTER", "FIXED MASS SCALING", "FLOW", "FLUID CAVITY", "FOUNDATION", "FRACTURE CRITERION",
    "FRAME SECTION", "FREQUENCY", "GAP", "GASKET SECTION", "GEL", "GEOSTATIC", "GLOBAL DAMPING", "HEAT GENERATION", "HEAT TRANSFER", "HEATCAP",
    "HOURGLASS STIFFNESS", "HYPERELASTIC", "HYPERFOAM", "HYSTERESIS", "IMPEDANCE", "IMPERFECTION", "IMPORT", "INCIDENT WAVE", "INCLUDE",
    "INELASTIC HEAT FRACTION", "INERTIA RELIEF", "INTEGRATED OUTPUT", "INTERFACE", "ITS", "JOINT", "JOINTED MATERIAL", "KAPPA", "LATENT HEAT",
    "LOAD CASE", "LOADING DATA", "LOW DENSITY FOAM", "MAP SOLUTION", "MASS ADJUST", "MASS DIFFUSION", "MASS FLOW RATE", "MATERIAL", "MATRIX",
    "MEMBRANE SECTION", "MODAL DAMPING", "MODAL DYNAMIC", "MODEL CHANGE", "MOHR COULOMB", "MOISTURE SWELLING", "MONITOR", "MOTION",
    "MULLINS EFFECT", "NO COMPRESSION", "NO TENSION", "NODAL ENERGY RATE", "NODAL THICKNESS", "NODE FILE", "NODE PRINT", "NODE RESPONSE",
    "NONSTRUCTURAL MASS", "NORMAL", "ORNL", "PARAMETER", "PARTICLE", "PERIODIC", "PERMEABILITY", "PHYSICAL CONSTANTS", "PIEZOELECTRIC",
    "PIPE-SOIL INTERACTION", "PLANAR TEST DATA", "PLASTIC", "POROUS ELASTIC", "POST OUTPUT", "POTENTIAL", "PRE-TENSION SECTION", "PREPRINT",
    "PRESSURE PENETRATION", "PRESSURE STRESS", "PRESTRESS HOLD", "PRINT", "PSD-DEFINITION", "RADIATE", "RADIATION OUTPUT", "RANDOM RESPONSE",
    "RATE DEPENDENT", "REBAR", "REFLECTION", "RELEASE", "RESPONSE SPECTRUM", "RESTART", "RETAINED NODAL DOFS", "RIGID SURFACE",
    "SECTION CONTROLS", "SECTION FILE", "SECTION ORIGIN", "SECTION PRINT", "SELECT EIGENMODES", "SFILM", "SFLOW", "SHEAR FAILURE",
    "SHELL GENERAL SECTION", "SHELL SECTION", "SHELL TO SOLID COUPLING", "SLIDE LINE", "SLOAD", "SOILS", "SOLID SECTION", "SOLUBILITY",
    "SOLUTION TECHNIQUE", "SOLVER CONTROLS", "SORPTION", "SPECIFIC HEAT", "SPECTRUM", "SRADIATE", "STEADY STATE DYNAMICS", "SUBCYCLING",
    "SUBMODEL", "SUBSTRUCTURE GENERATE", "SURFACE BEHAVIOR", "SURFACE INTERACTION", "SURFACE OUTPUT", "SURFACE PROPERTY", "SURFACE SECTION",
    "SWELLING", "SYMMETRIC MODEL GENERATION", "TEMPERATURE", "TENSILE FAILURE", "TENSION STIFFENING", "TIME POINTS", "TORQUE",
    "TRACER PARTICLE", "TRANSPORT VELOCITY", "TRANSVERSE SHEAR STIFFNESS", "TRIAXIAL TEST DATA", "TRS", "UEL PROPERTY", "UNIAXIAL",
    "UNLOADING DATA", "USER ELEMENT", "USER MATERIAL", "USER OUTPUT VARIABLES", "VARIABLE MASS SCALING", "VISCO", "VISCOELASTIC", "VISCOUS",
    "WAVE", "WIND",
    // Of CalculiX and others.
    "BOUNDARYF", "TRANSFORMF", "DASHPOT1", "SPRING1", "MODEL OUTPUT", "MODAL OUTPUT", "TRANSPORT",
];

/// What a name that is no keyword of its own may begin.
#[derive(Debug, PartialEq, Eq)]
pub(in crate::deck) enum Begun {
    /// This keyword.
    One(&'static str),
    /// Several, these that are read among them.
    Several(Vec<&'static str>),
    /// None that is read.
    None,
}

/// What a name begins, if it is no keyword that is known whole.
///
/// ```text
/// *BOUN  BOUNDARY        *ELEM  ELEMENT        *RIGID  RIGID BODY, or RIGID SURFACE        *FILM  (a keyword of its own)
/// ```
pub(in crate::deck) fn begun(name: &str) -> Begun {
    let bare = |name: &str| name.replace(' ', "");
    let given = bare(name);
    let read = || RULES.iter().map(|rule| rule.name);
    let all: Vec<&'static str> =
        read().chain(OTHERS.iter().copied()).filter(|known| bare(known).starts_with(&given)).collect();
    let Some(shortest) = all.iter().min_by_key(|known| bare(known).len()).filter(|_| !given.is_empty())
    else {
        return Begun::None;
    };
    let is_read = |known: &&'static str| read().any(|own| own == *known);
    if bare(shortest) == given {
        return Begun::None;
    }
    if all.iter().all(|known| bare(known).starts_with(&bare(shortest))) {
        return if is_read(shortest) { Begun::One(shortest) } else { Begun::None };
    }
    let of_ours: Vec<&'static str> = all.into_iter().filter(is_read).collect();
    if of_ours.is_empty() { Begun::None } else { Begun::Several(of_ours) }
}

/// Whether it is a keyword that is not read.
pub(super) fn is_other(name: &str) -> bool {
    OTHERS.contains(&name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beginnings_stand_for_one_keyword() {
        for (name, whole) in [
            ("BOUN", "BOUNDARY"),
            ("BOU", "BOUNDARY"),
            ("EQUA", "EQUATION"),
            ("EQU", "EQUATION"),
            ("ELEM", "ELEMENT"),
            ("ORIE", "ORIENTATION"),
            ("AMPL", "AMPLITUDE"),
            ("INST", "INSTANCE"),
            ("TRANSF", "TRANSFORM"),
            ("SURF", "SURFACE"),
            ("RIGID B", "RIGID BODY"),
            ("KINEMATIC COUP", "KINEMATIC COUPLING"),
            ("KINEM", "KINEMATIC"),
            ("CONNECTOR ELAS", "CONNECTOR ELASTICITY"),
            ("CONNECTOR SECT", "CONNECTOR SECTION"),
            ("HEAD", "HEADING"),
        ] {
            assert_eq!(begun(name), Begun::One(whole), "{name}");
        }
        // Whole keywords, those of others, and none.
        for name in
            ["FILM", "ELASTIC", "MATERI", "SOLID SEC", "NODE", "CONTACT", "STEP", "", "EQUATIONS", "XYZ"]
        {
            assert_eq!(begun(name), Begun::None, "{name}");
        }
        for (name, one) in [
            ("RIGID", "RIGID BODY"),
            ("COUP", "COUPLING"),
            ("CONN", "CONNECTOR SECTION"),
            ("DISTRIB", "DISTRIBUTING"),
        ] {
            assert!(matches!(begun(name), Begun::Several(all) if all.contains(&one)), "{name}");
        }
    }
}
