/* An element routine that pintle checks: pintle check TYPE --library ./element.so
 *
 * Build a shared library that defines pintle_offers, and pintle_element, pintle_mpc ("MPC KIND") or pintle_friction
 * ("FRICTION TYPE"):
 *     cc -shared -fPIC -O2 -o element.so element.c
 *
 * Lengths are in the unit of the scene, angles in rad, vectors along global axes.
 * Columns of rows are the degrees of freedom x1..x3, rotation 1..3 and material flow of node a, then of node b.
 * Rotations vary spatially: the triad e becomes e + theta x e. Components are u1, u2, u3, ur1, ur2, ur3.
 */
#ifndef PINTLE_ELEMENT_H
#define PINTLE_ELEMENT_H

#ifdef __cplusplus
extern "C" {
#endif

/* What a routine may give. */
enum {
    PINTLE_VALUES = 1,              /* residual of a constrained component, displacement of a free one */
    PINTLE_ROWS = 2,                /* their derivatives */
    PINTLE_SECOND_DERIVATIVES = 4,  /* symmetric */
    PINTLE_RATES = 8,
    PINTLE_ACCELERATIONS = 16,
    PINTLE_NODAL_FORCES = 32,       /* of a unit force of each component */
    PINTLE_GEOMETRIC_STIFFNESS = 64,
    PINTLE_ELEMENT_FORCES = 128,    /* of springs: --springs D1,...,D6 */
    PINTLE_ELEMENT_STIFFNESS = 256,
    PINTLE_CRITERION = 512,         /* of a friction: P, F_C, F_N, Phi */
    PINTLE_GRADIENTS = 1024,        /* their derivatives by the forces f1..m3 */
    PINTLE_FRICTION_FORCES = 2048,  /* after the increment */
    PINTLE_FRICTION_TANGENT = 4096  /* their derivatives by the increment, then by what presses */
};

typedef struct {
    double x[3];               /* position */
    double u[3];               /* displacement */
    double triad[3][3];        /* e1, e2, e3, each by its global components */
    double quaternion[4];      /* rotation since the initial state, scalar part first */
    double rotation_vector[3]; /* the same, principal */
    double flow;               /* material flow */
    double increment[3];       /* rotation vector since the state before */
    double velocity[7];        /* of x, rotation (spatial) and flow */
    double acceleration[7];
} pintle_node;

typedef struct {
    const char *type;       /* "REVOLUTE" */
    double x[2][3];         /* initial positions of a and b */
    double triad[2][3][3];  /* initial e1, e2, e3 of a and of b */
    int kind[6];            /* of each component: 1 constrained, 0 free, -1 none */
    double springs[6];      /* stiffness of each component, 0 for none */
    double flow_scale;
    int planar;
} pintle_connector;

typedef struct {
    pintle_node a, b;             /* now */
    pintle_node a_before, b_before; /* at the state before; at first the initial one; without rates */
    double values_before[6];      /* the right values there: angles go on from them */
} pintle_state;

/* What is not written stands for "no such component". Matrices: by row the force, by column the degree of freedom. */
typedef struct {
    double values[6];
    double rows[6][14];
    double second_derivatives[6][14][14];
    double rates[6];
    double accelerations[6];
    double nodal_forces[6][14];
    double geometric_stiffness[6][14][14];
    double element_forces[14];
    double element_stiffness[14][14];
} pintle_numbers;

/* A sum of what the routine gives. */
extern const unsigned pintle_offers;

/* How many numbers it keeps from state to state; may be left out. */
extern const int pintle_svars;

/* What differs from the conventions above, as JSON (docs/reference/protocol-answers.md); may be left out. */
extern const char *const pintle_convention;

/* Gives what is wanted at a state; svars are the routine's own, zero before the first state.
 * Returns 0, or another number where the state is outside its domain. */
int pintle_element(const pintle_connector *connector, const pintle_state *state, unsigned want, double *svars,
                   pintle_numbers *numbers);

/* A multi-point constraint: S follows M. Equations are delta1..delta3 (of a LINK the first is its length), rho1..rho3, flow. */
typedef struct {
    const char *type;     /* "MPC REVOLUTE" */
    double x[2][3];       /* initial positions of S and M */
    double axes[2][3];    /* a1, a2 of its hinges in the initial geometry */
    int has[7];           /* whether it has an equation */
} pintle_constraint;

typedef struct {
    pintle_node s, m;     /* now; the triad has the directions to which the global axes have turned */
    double angles[2];     /* phi1, phi2 of the hinges */
    double angle_velocities[2];
    double angle_accelerations[2];
} pintle_mpc_state;

/* Columns are those of S, those of M, then phi1 and phi2: 14 and one for each hinge. */
typedef struct {
    double values[7];
    double rows[7][16];
    double second_derivatives[7][16][16];
    double rates[7];
    double accelerations[7];
} pintle_mpc_numbers;

int pintle_mpc(const pintle_constraint *constraint, const pintle_mpc_state *state, unsigned want,
               pintle_mpc_numbers *numbers);

typedef struct {
    const char *type;       /* "FRICTION HINGE" */
    double coefficient;
    double maximum;         /* of the friction force, -1 for none */
    double stick_stiffness; /* K_s; -1 while the default rule has not set it */
    double parameters[8];   /* of a predefined friction, in the order of its data line */
} pintle_friction_data;

typedef struct {
    double forces[6];        /* the criterion is asked for at these: tractions where it slides, what presses elsewhere */
    double displacement[6];  /* of the increment */
    double pressing[6];      /* forces that press at its end */
    double forces_before[6]; /* friction forces before it */
    double slip_before;      /* accumulated slip before it */
    double position[6];
    double motion[6];
} pintle_friction_state;

typedef struct {
    double criterion[4];
    double gradients[4][6];
    double friction_forces[10];     /* CSF1..CSM3, slip of the increment, F_N, limit, accumulated slip */
    double friction_tangent[6][12];
} pintle_friction_numbers;

int pintle_friction(const pintle_friction_data *friction, const pintle_friction_state *state, unsigned want,
                    pintle_friction_numbers *numbers);

#ifdef __cplusplus
}
#endif
#endif
