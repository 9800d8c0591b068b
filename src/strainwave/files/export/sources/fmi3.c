/* The interface FMI 3.0 (co-simulation) to the plant in plant.c, without headers of others. */

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "instance.h"

typedef void (*logger)(void *, status, const char *, const char *);

typedef struct {
    kept my;
    void *environment;
    logger log;
} instance;

static status failed(const instance *one, const char *message)
{
    if (one && one->log) {
        one->log(one->environment, ERROR, "logStatusError", message);
    }
    return ERROR;
}

FMI(const char *, fmi3GetVersion)(void) { return "3.0"; }

FMI(component, fmi3InstantiateCoSimulation)(const char *name, const char *token, const char *resources, bool visible,
                                            bool logging, bool event_mode, bool early_return,
                                            const unsigned intermediate[], size_t intermediates, void *environment,
                                            logger log, void *intermediate_update)
{
    if (!token || strcmp(token, TOKEN)) {
        return NULL;
    }
    instance *one = calloc(1, sizeof(instance));
    if (one) {
        begin(&one->my, 0.0);
        one->environment = environment;
        one->log = log;
    }
    return one;
}

FMI(component, fmi3InstantiateModelExchange)(const char *name, const char *token, const char *resources, bool visible,
                                             bool logging, void *environment, logger log)
{
    return NULL;
}

FMI(component, fmi3InstantiateScheduledExecution)(const char *name, const char *token, const char *resources,
                                                  bool visible, bool logging, void *environment, logger log,
                                                  void *clock_update, void *lock, void *unlock)
{
    return NULL;
}

FMI(void, fmi3FreeInstance)(component c) { free(c); }

CHANGED(fmi3EnterInitializationMode, my->time = start, component c, bool has_tolerance, double tolerance, double start,
        bool has_stop, double stop)
CHANGED(fmi3Reset, begin(my, 0.0), component c)

EACH(fmi3GetFloat64, n == count && get_value(MINE, references[i], &values[i]),
     "there is no variable of this value reference", REFERENCES, double values[], size_t n)
EACH(fmi3SetFloat64, n == count && set_value(MINE, references[i], values[i]), UNSET, REFERENCES, const double values[],
     size_t n)

CHANGED(fmi3DoStep, {
    *event = *terminate = *early = false;
    my->time = time;
    const char *wrong = advance(my, span);
    *last = my->time;
    if (wrong) {
        return failed(c, wrong);
    }
}, component c, double time, double span, bool no_way_back, bool *event, bool *terminate, bool *early, double *last)

CHANGED(fmi3GetFMUState, {
    *state = *state ? *state : malloc(sizeof *my);
    return copied_all(*state, my);
}, component c, void **state)

CHANGED(fmi3SetFMUState, return copied_all(my, state), component c, void *state)

FMI(status, fmi3FreeFMUState)(component c, void **state)
{
    if (state) {
        free(*state);
        *state = NULL;
    }
    return c ? OK : ERROR;
}

/* Other kinds of variables: none. */
#define NO_VARIABLES(kind, type)                                                                                      \
    EACH(fmi3Get##kind, 0, "all variables are of the type Float64", REFERENCES, type values[], size_t n)              \
    EACH(fmi3Set##kind, 0, "all variables are of the type Float64", REFERENCES, const type values[], size_t n)
NO_VARIABLES(Float32, float)
NO_VARIABLES(Int8, int8_t)
NO_VARIABLES(UInt8, uint8_t)
NO_VARIABLES(Int16, int16_t)
NO_VARIABLES(UInt16, uint16_t)
NO_VARIABLES(Int32, int32_t)
NO_VARIABLES(UInt32, uint32_t)
NO_VARIABLES(Int64, int64_t)
NO_VARIABLES(UInt64, uint64_t)
NO_VARIABLES(Boolean, bool)
NO_VARIABLES(String, char *)

/* Calls that change nothing here. */
NOTHING(fmi3SetDebugLogging, component c, bool on, size_t count, const char *const categories[])
NOTHING(fmi3ExitInitializationMode, component c)
NOTHING(fmi3EnterStepMode, component c)
NOTHING(fmi3Terminate, component c)

/* What the model description says that this unit cannot do. */
REFUSED(fmi3GetBinary, REFERENCES, size_t sizes[], const uint8_t *values[], size_t n)
REFUSED(fmi3SetBinary, REFERENCES, const size_t sizes[], const uint8_t *const values[], size_t n)
REFUSED(fmi3GetClock, REFERENCES, bool values[])
REFUSED(fmi3SetClock, REFERENCES, const bool values[])
REFUSED(fmi3GetNumberOfVariableDependencies, component c, unsigned reference, size_t *count)
REFUSED(fmi3GetVariableDependencies, component c, unsigned dependent, size_t elements[], unsigned independents[],
        size_t others[], int kinds[], size_t count)
REFUSED(fmi3SerializedFMUStateSize, component c, void *state, size_t *size)
REFUSED(fmi3SerializeFMUState, component c, void *state, uint8_t bytes[], size_t size)
REFUSED(fmi3DeserializeFMUState, component c, const uint8_t bytes[], size_t size, void **state)
REFUSED(fmi3GetDirectionalDerivative, UNKNOWNS, const double seed[], size_t seeds, double found[], size_t n)
REFUSED(fmi3GetAdjointDerivative, UNKNOWNS, const double seed[], size_t seeds, double found[], size_t n)
REFUSED(fmi3GetOutputDerivatives, REFERENCES, const int32_t orders[], double values[], size_t n)
REFUSED(fmi3EnterConfigurationMode, component c)
REFUSED(fmi3ExitConfigurationMode, component c)
REFUSED(fmi3EnterEventMode, component c)
REFUSED(fmi3UpdateDiscreteStates, component c, bool *again, bool *terminate, bool *nominals, bool *values,
        bool *defined, double *time)
REFUSED(fmi3EvaluateDiscreteStates, component c)
REFUSED(fmi3GetIntervalDecimal, REFERENCES, double intervals[], int qualifiers[])
REFUSED(fmi3GetIntervalFraction, REFERENCES, uint64_t counters[], uint64_t resolutions[], int qualifiers[])
REFUSED(fmi3GetShiftDecimal, REFERENCES, double shifts[])
REFUSED(fmi3GetShiftFraction, REFERENCES, uint64_t counters[], uint64_t resolutions[])
REFUSED(fmi3SetIntervalDecimal, REFERENCES, const double intervals[])
REFUSED(fmi3SetIntervalFraction, REFERENCES, const uint64_t counters[], const uint64_t resolutions[])
REFUSED(fmi3SetShiftDecimal, REFERENCES, const double shifts[])
REFUSED(fmi3SetShiftFraction, REFERENCES, const uint64_t counters[], const uint64_t resolutions[])
REFUSED(fmi3EnterContinuousTimeMode, component c)
REFUSED(fmi3CompletedIntegratorStep, component c, bool no_way_back, bool *event, bool *terminate)
REFUSED(fmi3SetTime, component c, double time)
REFUSED(fmi3SetContinuousStates, component c, const double x[], size_t n)
REFUSED(fmi3GetContinuousStates, component c, double x[], size_t n)
REFUSED(fmi3GetContinuousStateDerivatives, component c, double rates[], size_t n)
REFUSED(fmi3GetEventIndicators, component c, double indicators[], size_t n)
REFUSED(fmi3GetNominalsOfContinuousStates, component c, double nominals[], size_t n)
REFUSED(fmi3GetNumberOfEventIndicators, component c, size_t *count)
REFUSED(fmi3GetNumberOfContinuousStates, component c, size_t *count)
REFUSED(fmi3ActivateModelPartition, component c, unsigned clock, double time)
