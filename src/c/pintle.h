/* pintle for C: what a connector gives at a state.
 *
 *     cargo build --release -p pintle-c
 *     cc -o program program.c -Isrc/c -Ltarget/release -lpintle_c -lm
 *
 * Lengths are in the unit of the scene, angles in rad, vectors along global axes. Components are u1, u2, u3, ur1, ur2, ur3.
 * Columns are x1..x3, rotation 1..3 and material flow of node a, then of node b; rotations vary spatially: e becomes e + theta x e.
 * Functions that return int return 0, or 1 where something is wrong: pintle_error says what. A handle serves one thread at a time.
 */
#ifndef PINTLE_H
#define PINTLE_H

#ifdef __cplusplus
extern "C" {
#endif

/* A connector, with the history that was committed. */
typedef struct pintle_handle pintle_handle;

/* Two nodes. */
typedef struct {
    double x[2][3];          /* positions of a and b */
    double triad[2][3][3];   /* e1, e2, e3 of a and of b, each by its global components */
    double flow[2];          /* material flow */
    double velocity[14];     /* by columns */
    double acceleration[14];
} pintle_pair;

/* "0.1.0". */
const char *pintle_version(void);

/* What was wrong in the last call of this thread that failed; it is valid until the next that fails. */
const char *pintle_error(void);

/* Opens a connection type, "REVOLUTE" or "CARTESIAN CARDAN", or a connector of a scene, "model.inp:106". NULL where there is none. */
pintle_handle *pintle_open(const char *name);

void pintle_close(pintle_handle *connector);

/* The initial state, at rest. */
int pintle_initial(const pintle_handle *connector, pintle_pair *pair);

/* Of each component: 1 constrained, 0 free, -1 none. */
int pintle_kinds(const pintle_handle *connector, int kinds[6]);

/* The residual of each constrained component, the displacement of a free one, and their derivatives; NaN for none.
 * Angles go on from the state that was committed last. rows may be NULL. */
int pintle_evaluate(const pintle_handle *connector, const pintle_pair *pair, double values[6], double rows[6][14]);

/* Their first and second time derivatives. */
int pintle_rates(const pintle_handle *connector, const pintle_pair *pair, double rates[6], double accelerations[6]);

/* Second derivatives, symmetric. */
int pintle_second_derivatives(const pintle_handle *connector, const pintle_pair *pair, double second[6][14][14]);

/* Commits a state: the next one goes on from it, by less than half a turn of each node. */
int pintle_commit(pintle_handle *connector, const pintle_pair *pair);

/* Back to the initial state. */
int pintle_reset(pintle_handle *connector);

#ifdef __cplusplus
}
#endif
#endif
