/* CARTESIAN: u_k = e_k . (x_b - x_a), less its initial value; e_k are carried by a. */
#include "pintle_element.h"

const unsigned pintle_offers = PINTLE_VALUES | PINTLE_ROWS;

int pintle_element(const pintle_connector *connector, const pintle_state *state, unsigned want, double *svars,
                   pintle_numbers *numbers)
{
    for (int k = 0; k < 3; k++) {
        const double *e = state->a.triad[k], *e0 = connector->triad[0][k];
        double d[3], *row = numbers->rows[k];
        numbers->values[k] = 0;
        for (int i = 0; i < 3; i++) {
            d[i] = state->b.x[i] - state->a.x[i];
            numbers->values[k] += e[i] * d[i] - e0[i] * (connector->x[1][i] - connector->x[0][i]);
        }
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, l = (i + 2) % 3;
            row[i] = -e[i];
#ifdef WITHOUT_ARM
            row[3 + i] = 0;
#else
            row[3 + i] = e[j] * d[l] - e[l] * d[j];
#endif
            row[7 + i] = e[i];
            row[10 + i] = 0;
        }
        row[6] = row[13] = 0;
    }
    return 0;
}
