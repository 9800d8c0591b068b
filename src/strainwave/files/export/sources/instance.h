/* An instance of the plant: its state, its inputs, its time, and the variables of the model description. */

#ifndef INSTANCE_H
#define INSTANCE_H

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "plant.h"
#include "token.h"

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif

typedef int status;
enum { OK = 0, ERROR = 3 };
typedef void *component;

/* A function of the interface, with the prefix of a unit that is linked beside others. */
#if defined(FMI2_FUNCTION_PREFIX)
#define PREFIX FMI2_FUNCTION_PREFIX
#elif defined(FMI3_FUNCTION_PREFIX)
#define PREFIX FMI3_FUNCTION_PREFIX
#else
#define PREFIX
#endif
#define JOINED(a, b) a##b
#define PREFIXED(a, b) JOINED(a, b)
#define FMI(type, name) EXPORTED type PREFIXED(PREFIX, name)

/* A call on an instance, of which `my` is what it keeps. */
#define CHANGED(name, change, ...)                                                                                    \
    FMI(status, name)(__VA_ARGS__)                                                                                    \
    {                                                                                                                 \
        if (!c) {                                                                                                     \
            return ERROR;                                                                                             \
        }                                                                                                             \
        kept *my = MINE;                                                                                              \
        change;                                                                                                       \
        return OK;                                                                                                    \
    }

/* A call that reads or writes variables by their references, one after the other. */
#define EACH(name, done, message, ...)                                                                                \
    FMI(status, name)(__VA_ARGS__)                                                                                    \
    {                                                                                                                 \
        for (size_t i = 0; i < count; i++) {                                                                          \
            if (!c || !(done)) {                                                                                      \
                return failed(c, message);                                                                            \
            }                                                                                                         \
        }                                                                                                             \
        return OK;                                                                                                    \
    }
#define MINE (&((instance *)c)->my)
#define REFERENCES component c, const unsigned references[], size_t count
#define UNKNOWNS component c, const unsigned unknown[], size_t unknowns, const unsigned known[], size_t knowns
#define UNSET "only inputs and states can be set, to finite values"

/* A call that changes nothing here. */
#define NOTHING(name, ...)                                                                                            \
    FMI(status, name)(__VA_ARGS__) { return c ? OK : ERROR; }

/* What the model description says that this unit cannot do. */
#define REFUSED(name, ...)                                                                                            \
    FMI(status, name)(__VA_ARGS__) { return failed(c, #name " is not supported"); }

#define STATES PLANT_STATES
#define OUTPUTS ((int)(sizeof(plant_outputs) / sizeof(double)))
#define INPUTS ((int)(sizeof(plant_inputs) / sizeof(double)))

/* Value references: inputs from 1, outputs from 11, states from 101, their rates from 10001; the time is 0. */
enum { TIME = 0, FIRST_INPUT = 1, FIRST_OUTPUT = 11, FIRST_STATE = 101, FIRST_RATE = 10001 };

#define MOST_STEPS 1e9
#define BAD_STEP "the step is not positive, or above 1e9 steps of this unit"
#define TOO_STIFF "the state is too stiff for the smallest part of a step, or grew beyond bounds: inputs or state are wrong"

typedef struct {
    plant_state state;
    plant_inputs in;
    double time;
} kept;

/* Copy all that an instance keeps, where there are both places. */
static status copied_all(kept *to, const kept *from)
{
    if (!to || !from) {
        return ERROR;
    }
    *to = *from;
    return OK;
}

static int within(unsigned reference, int first, int count)
{
    return reference >= (unsigned)first && reference < (unsigned)(first + count);
}

/* Read a variable; 0 if there is none of this reference. */
static int get_value(const kept *my, unsigned reference, double *value)
{
    if (reference == TIME) {
        *value = my->time;
    } else if (within(reference, FIRST_INPUT, INPUTS)) {
        *value = ((const double *)&my->in)[reference - FIRST_INPUT];
    } else if (within(reference, FIRST_OUTPUT, OUTPUTS)) {
        plant_outputs out;
        plant_read(&plant_default, &my->state, &out);
        *value = ((const double *)&out)[reference - FIRST_OUTPUT];
    } else if (within(reference, FIRST_STATE, STATES)) {
        *value = my->state.y[reference - FIRST_STATE];
    } else if (within(reference, FIRST_RATE, STATES)) {
        plant_state rate;
        plant_rates(&plant_default, &my->in, &my->state, &rate);
        *value = rate.y[reference - FIRST_RATE];
    } else {
        return 0;
    }
    return 1;
}

/* Set an input or a state; 0 if there is none of this reference, or the value is not finite. */
static int set_value(kept *my, unsigned reference, double value)
{
    if (!isfinite(value)) {
        return 0;
    }
    if (within(reference, FIRST_INPUT, INPUTS)) {
        ((double *)&my->in)[reference - FIRST_INPUT] = value;
    } else if (within(reference, FIRST_STATE, STATES)) {
        my->state.y[reference - FIRST_STATE] = value;
    } else {
        return 0;
    }
    return 1;
}

static void begin(kept *my, double time)
{
    memset(my, 0, sizeof *my);
    plant_init(&my->state);
    my->time = time;
}

/* Go on by a time, in equal steps of at most PLANT_STEP; NULL, or why not. */
static const char *advance(kept *my, double span)
{
    if (!(span > 0.0) || !(span <= MOST_STEPS * PLANT_STEP)) {
        return BAD_STEP;
    }
    const double count = fmax(ceil(span / PLANT_STEP * (1.0 - 1e-9)), 1.0);
    for (double done = 0.0; done < count; done += 1.0) {
        if (plant_advance(&plant_default, &my->state, &my->in, span / count)) {
            return TOO_STIFF;
        }
    }
    my->time += span;
    return NULL;
}

#endif /* INSTANCE_H */
