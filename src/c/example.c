/* A REVOLUTE turned about its axis three quarters of a turn, in steps: its angle goes on through half a turn. */
#include "pintle.h"
#include <math.h>
#include <stdio.h>

/* Turns the triad of b about e1 of a by an angle. */
static void turn(pintle_pair *pair, const pintle_pair *initial, double angle)
{
    const double *n = initial->triad[0][0];
    for (int k = 0; k < 3; k++) {
        const double *e = initial->triad[1][k];
        double along = n[0] * e[0] + n[1] * e[1] + n[2] * e[2];
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, l = (i + 2) % 3;
            double across = n[j] * e[l] - n[l] * e[j];
            pair->triad[1][k][i] = along * n[i] + cos(angle) * (e[i] - along * n[i]) + sin(angle) * across;
        }
    }
}

int main(void)
{
    double values[6], rows[6][14], rates[6], accelerations[6];
    static double second[6][14][14];
    int kinds[6];
    pintle_pair initial, pair;
    pintle_handle *joint = pintle_open("REVOLUTE");
    if (!joint || pintle_initial(joint, &initial) || pintle_kinds(joint, kinds))
        return fprintf(stderr, "%s\n", pintle_error()), 1;
    pair = initial;
    for (int step = 1; step <= 3; step++) {
        turn(&pair, &initial, step * acos(0.0));
        if (step < 3 && pintle_commit(joint, &pair))
            return fprintf(stderr, "%s\n", pintle_error()), 1;
    }
    for (int i = 0; i < 3; i++)
        pair.velocity[10 + i] = 2 * initial.triad[0][0][i];
    if (pintle_evaluate(joint, &pair, values, rows) || pintle_rates(joint, &pair, rates, accelerations)
        || pintle_second_derivatives(joint, &pair, second))
        return fprintf(stderr, "%s\n", pintle_error()), 1;
    double along = 0;
    for (int i = 0; i < 3; i++)
        along += rows[3][10 + i] * initial.triad[0][0][i];
    printf("kinds %d %d %d\n", kinds[3], kinds[4], kinds[5]);
    printf("ur1 %.12f rate %.12f row %.12f\n", values[3], rates[3], along);
    pintle_reset(joint);
    pintle_evaluate(joint, &pair, values, NULL);
    printf("from the initial state %.12f\n", values[3]);
    pintle_close(joint);
    printf("%s\n", pintle_open("NO SUCH TYPE") ? "opened" : pintle_error());
    pair.x[0][0] = NAN;
    joint = pintle_open("AXIAL");
    if (pintle_evaluate(joint, &pair, values, NULL))
        printf("%s\n", pintle_error());
    if (pintle_evaluate(NULL, &pair, values, NULL))
        printf("%s\n", pintle_error());
    pintle_close(joint);
    return 0;
}
