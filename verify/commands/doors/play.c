/* Plays a tape of answers as a routine of pintle_element.h: of a connector, a constraint or a friction. */
#define pintle_offers as_declared
#include "pintle_element.h"
#undef pintle_offers
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
unsigned pintle_offers;
static double *tape;
static size_t count;
__attribute__((constructor)) static void begin(void) {
    FILE *file = fopen(getenv("TAPE"), "rb");
    pintle_offers = (unsigned)strtoul(getenv("BITS"), NULL, 10);
    fseek(file, 0, SEEK_END);
    count = (size_t)ftell(file) / sizeof *tape;
    rewind(file);
    tape = malloc(count * sizeof *tape);
    count = fread(tape, sizeof *tape, count, file);
    fclose(file);
}
static const double *found(unsigned want, const void *state, size_t size) {
    for (size_t at = 0; at < count; at += 1 + (size_t)tape[at])
        if (tape[at + 1] == want && !memcmp(tape + at + 2, state, size)) return tape + at + 2 + size / sizeof *tape;
    return NULL;
}
#define TAKE(bit, name) \
    if (want & bit) { memcpy(numbers->name, from, sizeof numbers->name); from += sizeof numbers->name / sizeof *from; }
#define BEGIN const double *from = found(want, state, sizeof *state); if (!from) return 1;
#ifdef ELEMENT
int pintle_element(const pintle_connector *connector, const pintle_state *state, unsigned want, double *svars,
                   pintle_numbers *numbers) {
    BEGIN
    TAKE(PINTLE_VALUES, values)
    TAKE(PINTLE_ROWS, rows)
    TAKE(PINTLE_SECOND_DERIVATIVES, second_derivatives)
    TAKE(PINTLE_RATES, rates)
    TAKE(PINTLE_ACCELERATIONS, accelerations)
    TAKE(PINTLE_NODAL_FORCES, nodal_forces)
    TAKE(PINTLE_GEOMETRIC_STIFFNESS, geometric_stiffness)
    TAKE(PINTLE_ELEMENT_FORCES, element_forces)
    TAKE(PINTLE_ELEMENT_STIFFNESS, element_stiffness)
    return 0;
}
#elif defined MPC
int pintle_mpc(const pintle_constraint *constraint, const pintle_mpc_state *state, unsigned want,
               pintle_mpc_numbers *numbers) {
    BEGIN
    TAKE(PINTLE_VALUES, values)
    TAKE(PINTLE_ROWS, rows)
    TAKE(PINTLE_SECOND_DERIVATIVES, second_derivatives)
    TAKE(PINTLE_RATES, rates)
    TAKE(PINTLE_ACCELERATIONS, accelerations)
    return 0;
}
#else
int pintle_friction(const pintle_friction_data *friction, const pintle_friction_state *state, unsigned want,
                    pintle_friction_numbers *numbers) {
    BEGIN
    TAKE(PINTLE_CRITERION, criterion)
    TAKE(PINTLE_GRADIENTS, gradients)
    TAKE(PINTLE_FRICTION_FORCES, friction_forces)
    TAKE(PINTLE_FRICTION_TANGENT, friction_tangent)
    return 0;
}
#endif
