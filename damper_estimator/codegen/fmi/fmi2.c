/*
 * FMI 2.0 for co-simulation. The declarations follow the standard (version 2.0.4, sections 2 and 4); no file
 * of the standard is copied.
 */
#include "unit.h"

typedef unsigned int fmi2ValueReference;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef void (*fmi2Logger)(void *, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
typedef struct {
    fmi2Logger logger;
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(void *, fmi2Status);
    void *environment;
} fmi2Callbacks;

static fmi2Status answer(bool done)
{
    return done ? fmi2OK : fmi2Error;
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT void *fmi2Instantiate(fmi2String name, int type, fmi2String token, fmi2String resources,
    const fmi2Callbacks *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    return (type == 1) ? unit_new(token) : NULL; /* 1: co-simulation */
}

EXPORT void fmi2FreeInstance(void *c) { free(c); }
EXPORT fmi2Status fmi2SetDebugLogging(void *c, fmi2Boolean on, size_t n, const fmi2String categories[]) { return fmi2OK; }

EXPORT fmi2Status fmi2SetupExperiment(void *c, fmi2Boolean tolerant, double tolerance, double start,
    fmi2Boolean ends, double stop)
{
    ((unit *)c)->start = start;
    return answer(fabs(start) < LATEST);
}

EXPORT fmi2Status fmi2EnterInitializationMode(void *c) { return fmi2OK; }
EXPORT fmi2Status fmi2ExitInitializationMode(void *c) { return answer(unit_sample(c, ((unit *)c)->start)); }
EXPORT fmi2Status fmi2Terminate(void *c) { return fmi2OK; }

EXPORT fmi2Status fmi2Reset(void *c)
{
    unit_reset(c);
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetReal(void *c, const fmi2ValueReference r[], size_t n, double value[])
{
    bool done = true;
    for (size_t i = 0; i < n; ++i) {
        done = unit_get(c, r[i], &value[i]) && done;
    }
    return answer(done);
}

EXPORT fmi2Status fmi2SetReal(void *c, const fmi2ValueReference r[], size_t n, const double value[])
{
    bool done = true;
    for (size_t i = 0; i < n; ++i) {
        done = unit_set(c, r[i], value[i]) && done;
    }
    return answer(done);
}

EXPORT fmi2Status fmi2GetInteger(void *c, const fmi2ValueReference r[], size_t n, int value[])
{
    bool done = true;
    for (size_t i = 0; i < n; ++i) {
        int32_t found = 0;
        done = unit_get_integer(c, r[i], &found) && done;
        value[i] = (int)found;
    }
    return answer(done);
}

EXPORT fmi2Status fmi2GetBoolean(void *c, const fmi2ValueReference r[], size_t n, fmi2Boolean value[])
{
    for (size_t i = 0; i < n; ++i) {
        if (r[i] != REACHED) {
            return fmi2Error;
        }
        value[i] = ((unit *)c)->reached ? 1 : 0;
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2DoStep(void *c, double time, double length, fmi2Boolean no_return)
{
    return answer(unit_step(c, time, length));
}

EXPORT fmi2Status fmi2GetFMUstate(void *c, void **state)
{
    if (*state == NULL) {
        *state = malloc(sizeof(unit));
    }
    if (*state == NULL) {
        return fmi2Error;
    }
    *(unit *)*state = *(unit *)c;
    return fmi2OK;
}

EXPORT fmi2Status fmi2SetFMUstate(void *c, void *state)
{
    unit_restore(c, state);
    return fmi2OK;
}

EXPORT fmi2Status fmi2FreeFMUstate(void *c, void **state)
{
    free(*state);
    *state = NULL;
    return fmi2OK;
}

/* Functions that this unit does not support. */
#define REFUSED { return fmi2Error; }
EXPORT fmi2Status fmi2GetString(void *c, const fmi2ValueReference r[], size_t n, fmi2String value[]) REFUSED
EXPORT fmi2Status fmi2SetInteger(void *c, const fmi2ValueReference r[], size_t n, const int value[]) REFUSED
EXPORT fmi2Status fmi2SetBoolean(void *c, const fmi2ValueReference r[], size_t n, const fmi2Boolean value[]) REFUSED
EXPORT fmi2Status fmi2SetString(void *c, const fmi2ValueReference r[], size_t n, const fmi2String value[]) REFUSED
EXPORT fmi2Status fmi2SerializedFMUstateSize(void *c, void *state, size_t *size) REFUSED
EXPORT fmi2Status fmi2SerializeFMUstate(void *c, void *state, char bytes[], size_t size) REFUSED
EXPORT fmi2Status fmi2DeSerializeFMUstate(void *c, const char bytes[], size_t size, void **state) REFUSED
EXPORT fmi2Status fmi2GetDirectionalDerivative(void *c, const fmi2ValueReference unknown[], size_t n,
    const fmi2ValueReference known[], size_t m, const double in[], double out[]) REFUSED
EXPORT fmi2Status fmi2SetRealInputDerivatives(void *c, const fmi2ValueReference r[], size_t n, const int order[],
    const double value[]) REFUSED
EXPORT fmi2Status fmi2GetRealOutputDerivatives(void *c, const fmi2ValueReference r[], size_t n, const int order[],
    double value[]) REFUSED
EXPORT fmi2Status fmi2CancelStep(void *c) REFUSED
EXPORT fmi2Status fmi2GetStatus(void *c, int kind, fmi2Status *value) REFUSED
EXPORT fmi2Status fmi2GetRealStatus(void *c, int kind, double *value) REFUSED
EXPORT fmi2Status fmi2GetIntegerStatus(void *c, int kind, int *value) REFUSED
EXPORT fmi2Status fmi2GetBooleanStatus(void *c, int kind, fmi2Boolean *value) REFUSED
EXPORT fmi2Status fmi2GetStringStatus(void *c, int kind, fmi2String *value) REFUSED
