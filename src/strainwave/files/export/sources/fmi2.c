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

FMI(status, fmi2GetReal)(component c, const unsigned references[], size_t count, double values[])
{
    for (size_t i = 0; i < count; i++) {
        if (!c || !get_value(&((instance *)c)->my, references[i], &values[i])) {
            return failed(c, "there is no real variable of this value reference");
        }
    }
    return OK;
}

FMI(status, fmi2SetReal)(component c, const unsigned references[], size_t count, const double values[])
{
    for (size_t i = 0; i < count; i++) {
        if (!c || !set_value(&((instance *)c)->my, references[i], values[i])) {
            return failed(c, "only inputs and states can be set, to finite values");
        }
    }
    return OK;
}

/* Other kinds of variables: none. */
#define NO_VARIABLES(kind, type)                                                                                      \
    FMI(status, fmi2Get##kind)(component c, const unsigned references[], size_t count, type values[])                 \
    {                                                                                                                 \
        return count ? failed(c, "all variables are real") : OK;                                                      \
    }                                                                                                                 \
    FMI(status, fmi2Set##kind)(component c, const unsigned references[], size_t count, const type values[])           \
    {                                                                                                                 \
        return count ? failed(c, "all variables are real") : OK;                                                      \
    }
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
REFUSED(fmi2GetDirectionalDerivative, component c, const unsigned unknown[], size_t unknowns, const unsigned known[],
        size_t knowns, const double given[], double found[])
REFUSED(fmi2SetRealInputDerivatives, component c, const unsigned references[], size_t count, const int orders[],
        const double values[])
REFUSED(fmi2GetRealOutputDerivatives, component c, const unsigned references[], size_t count, const int orders[],
        double values[])
REFUSED(fmi2GetStatus, component c, int kind, status *value)
REFUSED(fmi2GetRealStatus, component c, int kind, double *value)
REFUSED(fmi2GetIntegerStatus, component c, int kind, int *value)
REFUSED(fmi2GetBooleanStatus, component c, int kind, int *value)
REFUSED(fmi2GetStringStatus, component c, int kind, const char **value)

FMI(status, fmi2GetFMUstate)(component c, void **state)
{
    instance *one = c;
    if (!one || (!*state && !(*state = one->functions->allocate(1, sizeof(kept))))) {
        return ERROR;
    }
    memcpy(*state, &one->my, sizeof(kept));
    return OK;
}

FMI(status, fmi2SetFMUstate)(component c, void *state)
{
    if (!c || !state) {
        return ERROR;
    }
    memcpy(&((instance *)c)->my, state, sizeof(kept));
    return OK;
}

FMI(status, fmi2FreeFMUstate)(component c, void **state)
{
    if (!c) {
        return ERROR;
    }
    if (state && *state) {
        ((instance *)c)->functions->release(*state);
        *state = NULL;
    }
    return OK;
}

FMI(status, fmi2DoStep)(component c, double time, double span, int no_way_back)
{
    instance *one = c;
    if (!one) {
        return ERROR;
    }
    one->my.time = time;
    const char *wrong = advance(&one->my, span);
    return wrong ? failed(one, wrong) : OK;
}

FMI(status, fmi2NewDiscreteStates)(component c, event_info *info)
{
    memset(info, 0, sizeof *info);
    return c ? OK : ERROR;
}

FMI(status, fmi2CompletedIntegratorStep)(component c, int no_way_back, int *event_mode, int *terminate)
{
    *event_mode = *terminate = 0;
    return c ? OK : ERROR;
}

static status copied(const component c, size_t count, double *to, const double *from)
{
    if (!c || count != STATES) {
        return failed(c, "the number of continuous states is another");
    }
    memcpy(to, from, sizeof(double) * STATES);
    return OK;
}

FMI(status, fmi2SetContinuousStates)(component c, const double x[], size_t count)
{
    return c ? copied(c, count, ((instance *)c)->my.state.y, x) : ERROR;
}

FMI(status, fmi2GetContinuousStates)(component c, double x[], size_t count)
{
    return c ? copied(c, count, x, ((instance *)c)->my.state.y) : ERROR;
}

FMI(status, fmi2GetDerivatives)(component c, double rates[], size_t count)
{
    plant_state rate;
    if (!c) {
        return ERROR;
    }
    plant_rates(&plant_default, &((instance *)c)->my.in, &((instance *)c)->my.state, &rate);
    return copied(c, count, rates, rate.y);
}

FMI(status, fmi2GetNominalsOfContinuousStates)(component c, double nominals[], size_t count)
{
    for (size_t i = 0; i < count; i++) {
        nominals[i] = 1.0;
    }
    return c ? OK : ERROR;
}
