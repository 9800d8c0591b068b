/* The interface FMI 2.0 (model exchange and co-simulation) to the plant in plant.c, without headers of others. */

#include "instance.h"

typedef void (*logger)(void *, const char *, status, const char *, const char *, ...);

typedef struct {
    logger log;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *step_finished;
    void *environment;
} callbacks;

typedef struct {
    int new_discrete_states, terminate, nominals_changed, values_changed, next_event_defined;
    double next_event;
} event_info;

typedef struct {
    kept my;
    const callbacks *functions;
    char name[64];
} instance;

static status failed(const instance *one, const char *message)
{
    if (one && one->functions && one->functions->log) {
        one->functions->log(one->functions->environment, one->name, ERROR, "logStatusError", message);
    }
    return ERROR;
}

FMI(const char *, fmi2GetTypesPlatform)(void) { return "default"; }
FMI(const char *, fmi2GetVersion)(void) { return "2.0"; }

FMI(component, fmi2Instantiate)(const char *name, int type, const char *token, const char *resources,
                                const callbacks *functions, int visible, int logging)
{
    if (!functions || !functions->allocate || !functions->release || !token || strcmp(token, TOKEN)) {
        return NULL;
    }
    instance *one = functions->allocate(1, sizeof(instance));
    if (one) {
        begin(&one->my, 0.0);
        one->functions = functions;
        strncpy(one->name, name ? name : "", sizeof one->name - 1);
    }
    return one;
}

FMI(void, fmi2FreeInstance)(component c)
{
    if (c) {
        ((instance *)c)->functions->release(c);
    }
}

CHANGED(fmi2SetupExperiment, my->time = start, component c, int has_tolerance, double tolerance, double start,
        int has_stop, double stop)
CHANGED(fmi2Reset, begin(my, 0.0), component c)
CHANGED(fmi2SetTime, my->time = time, component c, double time)

EACH(fmi2GetReal, get_value(MINE, references[i], &values[i]), "there is no real variable of this value reference",
     REFERENCES, double values[])
EACH(fmi2SetReal, set_value(MINE, references[i], values[i]), UNSET, REFERENCES, const double values[])

/* Other kinds of variables: none. */
#define NO_VARIABLES(kind, type)                                                                                      \
    EACH(fmi2Get##kind, 0, "all variables are real", REFERENCES, type values[])                                       \
    EACH(fmi2Set##kind, 0, "all variables are real", REFERENCES, const type values[])
NO_VARIABLES(Integer, int)
NO_VARIABLES(Boolean, int)
NO_VARIABLES(String, char *)

/* Calls that change nothing here. */
NOTHING(fmi2SetDebugLogging, component c, int on, size_t count, const char *const categories[])
NOTHING(fmi2EnterInitializationMode, component c)
NOTHING(fmi2ExitInitializationMode, component c)
NOTHING(fmi2Terminate, component c)
NOTHING(fmi2EnterEventMode, component c)
NOTHING(fmi2EnterContinuousTimeMode, component c)
NOTHING(fmi2GetEventIndicators, component c, double indicators[], size_t count)
NOTHING(fmi2CancelStep, component c)

/* What the model description says that this unit cannot do. */
REFUSED(fmi2SerializedFMUstateSize, component c, void *state, size_t *size)
REFUSED(fmi2SerializeFMUstate, component c, void *state, char bytes[], size_t size)
REFUSED(fmi2DeSerializeFMUstate, component c, const char bytes[], size_t size, void **state)
REFUSED(fmi2GetDirectionalDerivative, UNKNOWNS, const double given[], double found[])
REFUSED(fmi2SetRealInputDerivatives, REFERENCES, const int orders[], const double values[])
REFUSED(fmi2GetRealOutputDerivatives, REFERENCES, const int orders[], double values[])
REFUSED(fmi2GetStatus, component c, int kind, status *value)
REFUSED(fmi2GetRealStatus, component c, int kind, double *value)
REFUSED(fmi2GetIntegerStatus, component c, int kind, int *value)
REFUSED(fmi2GetBooleanStatus, component c, int kind, int *value)
REFUSED(fmi2GetStringStatus, component c, int kind, const char **value)

CHANGED(fmi2GetFMUstate, {
    *state = *state ? *state : ((instance *)c)->functions->allocate(1, sizeof *my);
    return copied_all(*state, my);
}, component c, void **state)

CHANGED(fmi2SetFMUstate, return copied_all(my, state), component c, void *state)

CHANGED(fmi2FreeFMUstate, {
    (void)my;
    if (state && *state) {
        ((instance *)c)->functions->release(*state);
        *state = NULL;
    }
}, component c, void **state)

CHANGED(fmi2DoStep, {
    my->time = time;
    const char *wrong = advance(my, span);
    if (wrong) {
        return failed(c, wrong);
    }
}, component c, double time, double span, int no_way_back)

CHANGED(fmi2NewDiscreteStates, (void)my; memset(info, 0, sizeof *info), component c, event_info *info)
CHANGED(fmi2CompletedIntegratorStep, (void)my; *event_mode = *terminate = 0, component c, int no_way_back,
        int *event_mode, int *terminate)

static status copied(const component c, size_t count, double *to, const double *from)
{
    if (!c || count != STATES) {
        return failed(c, "the number of continuous states is another");
    }
    memcpy(to, from, sizeof(double) * STATES);
    return OK;
}

CHANGED(fmi2SetContinuousStates, return copied(c, count, my->state.y, x), component c, const double x[], size_t count)
CHANGED(fmi2GetContinuousStates, return copied(c, count, x, my->state.y), component c, double x[], size_t count)

CHANGED(fmi2GetDerivatives, {
    plant_state rate;
    plant_rates(&plant_default, &my->in, &my->state, &rate);
    return copied(c, count, rates, rate.y);
}, component c, double rates[], size_t count)

EACH(fmi2GetNominalsOfContinuousStates, nominals[i] = 1.0, "", component c, double nominals[], size_t count)
