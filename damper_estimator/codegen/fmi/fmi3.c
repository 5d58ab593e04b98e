/*
 * FMI 3.0 for co-simulation. The declarations follow the standard (version 3.0, sections 2 and 4); no file of
 * the standard is copied.
 */
#include "unit.h"

typedef uint32_t fmi3ValueReference;
typedef const char *fmi3String;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void (*fmi3Callback)(void);

static fmi3Status answer(bool done)
{
    return done ? fmi3OK : fmi3Error;
}

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT void *fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, bool visible,
    bool logging, bool event_mode, bool early_return, const fmi3ValueReference intermediate[], size_t n,
    void *environment, fmi3Callback log, fmi3Callback update)
{
    return unit_new(token);
}

EXPORT void *fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, bool visible,
    bool logging, void *environment, fmi3Callback log)
{
    return NULL;
}

EXPORT void *fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, bool visible,
    bool logging, void *environment, fmi3Callback log, fmi3Callback clock, fmi3Callback lock, fmi3Callback unlock)
{
    return NULL;
}

EXPORT void fmi3FreeInstance(void *c) { free(c); }
EXPORT fmi3Status fmi3SetDebugLogging(void *c, bool on, size_t n, const fmi3String categories[]) { return fmi3OK; }

EXPORT fmi3Status fmi3EnterInitializationMode(void *c, bool tolerant, double tolerance, double start, bool ends,
    double stop)
{
    ((unit *)c)->start = start;
    return answer(fabs(start) < LATEST);
}

EXPORT fmi3Status fmi3ExitInitializationMode(void *c) { return answer(unit_sample(c, ((unit *)c)->start)); }
EXPORT fmi3Status fmi3Terminate(void *c) { return fmi3OK; }

EXPORT fmi3Status fmi3Reset(void *c)
{
    unit_reset(c);
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetFloat64(void *c, const fmi3ValueReference r[], size_t n, double value[], size_t m)
{
    bool done = n == m;
    for (size_t i = 0; done && (i < n); ++i) {
        done = unit_get(c, r[i], &value[i]);
    }
    return answer(done);
}

EXPORT fmi3Status fmi3SetFloat64(void *c, const fmi3ValueReference r[], size_t n, const double value[], size_t m)
{
    bool done = n == m;
    for (size_t i = 0; done && (i < n); ++i) {
        done = unit_set(c, r[i], value[i]);
    }
    return answer(done);
}

EXPORT fmi3Status fmi3GetInt32(void *c, const fmi3ValueReference r[], size_t n, int32_t value[], size_t m)
{
    bool done = n == m;
    for (size_t i = 0; done && (i < n); ++i) {
        done = unit_get_integer(c, r[i], &value[i]);
    }
    return answer(done);
}

EXPORT fmi3Status fmi3GetBoolean(void *c, const fmi3ValueReference r[], size_t n, bool value[], size_t m)
{
    for (size_t i = 0; i < n; ++i) {
        if ((r[i] != REACHED) || (n != m)) {
            return fmi3Error;
        }
        value[i] = ((unit *)c)->reached;
    }
    return fmi3OK;
}

EXPORT fmi3Status fmi3DoStep(void *c, double time, double length, bool no_return, bool *event, bool *terminate,
    bool *early, double *last)
{
    const bool done = unit_step(c, time, length);
    *event = false;
    *terminate = false;
    *early = false;
    *last = done ? time + length : time;
    return answer(done);
}

EXPORT fmi3Status fmi3GetFMUState(void *c, void **state)
{
    if (*state == NULL) {
        *state = malloc(sizeof(unit));
    }
    if (*state == NULL) {
        return fmi3Error;
    }
    *(unit *)*state = *(unit *)c;
    return fmi3OK;
}

EXPORT fmi3Status fmi3SetFMUState(void *c, void *state)
{
    unit_restore(c, state);
    return fmi3OK;
}

EXPORT fmi3Status fmi3FreeFMUState(void *c, void **state)
{
    free(*state);
    *state = NULL;
    return fmi3OK;
}

/* Functions that this unit does not support. */
#define REFUSED { return fmi3Error; }
#define REFUSED_TYPE(name, type) \
    EXPORT fmi3Status fmi3Get##name(void *c, const fmi3ValueReference r[], size_t n, type value[], size_t m) REFUSED \
    EXPORT fmi3Status fmi3Set##name(void *c, const fmi3ValueReference r[], size_t n, const type value[], size_t m) REFUSED
REFUSED_TYPE(Float32, float)
REFUSED_TYPE(Int8, int8_t)
REFUSED_TYPE(UInt8, uint8_t)
REFUSED_TYPE(Int16, int16_t)
REFUSED_TYPE(UInt16, uint16_t)
REFUSED_TYPE(UInt32, uint32_t)
REFUSED_TYPE(Int64, int64_t)
REFUSED_TYPE(UInt64, uint64_t)
REFUSED_TYPE(String, fmi3String)
EXPORT fmi3Status fmi3SetInt32(void *c, const fmi3ValueReference r[], size_t n, const int32_t value[], size_t m) REFUSED
EXPORT fmi3Status fmi3SetBoolean(void *c, const fmi3ValueReference r[], size_t n, const bool value[], size_t m) REFUSED
EXPORT fmi3Status fmi3GetBinary(void *c, const fmi3ValueReference r[], size_t n, size_t sizes[], const uint8_t *value[],
    size_t m) REFUSED
EXPORT fmi3Status fmi3SetBinary(void *c, const fmi3ValueReference r[], size_t n, const size_t sizes[],
    const uint8_t *const value[], size_t m) REFUSED
EXPORT fmi3Status fmi3GetClock(void *c, const fmi3ValueReference r[], size_t n, bool value[]) REFUSED
EXPORT fmi3Status fmi3SetClock(void *c, const fmi3ValueReference r[], size_t n, const bool value[]) REFUSED
EXPORT fmi3Status fmi3GetNumberOfVariableDependencies(void *c, fmi3ValueReference r, size_t *n) REFUSED
EXPORT fmi3Status fmi3GetVariableDependencies(void *c, fmi3ValueReference r, size_t dependent[],
    fmi3ValueReference independent[], size_t elements[], int kinds[], size_t n) REFUSED
EXPORT fmi3Status fmi3SerializedFMUStateSize(void *c, void *state, size_t *size) REFUSED
EXPORT fmi3Status fmi3SerializeFMUState(void *c, void *state, uint8_t bytes[], size_t size) REFUSED
EXPORT fmi3Status fmi3DeserializeFMUState(void *c, const uint8_t bytes[], size_t size, void **state) REFUSED
EXPORT fmi3Status fmi3GetDirectionalDerivative(void *c, const fmi3ValueReference unknown[], size_t n,
    const fmi3ValueReference known[], size_t m, const double seed[], size_t k, double value[], size_t l) REFUSED
EXPORT fmi3Status fmi3GetAdjointDerivative(void *c, const fmi3ValueReference unknown[], size_t n,
    const fmi3ValueReference known[], size_t m, const double seed[], size_t k, double value[], size_t l) REFUSED
EXPORT fmi3Status fmi3EnterConfigurationMode(void *c) REFUSED
EXPORT fmi3Status fmi3ExitConfigurationMode(void *c) REFUSED
EXPORT fmi3Status fmi3EnterEventMode(void *c) REFUSED
EXPORT fmi3Status fmi3EnterContinuousTimeMode(void *c) REFUSED
EXPORT fmi3Status fmi3EnterStepMode(void *c) REFUSED
EXPORT fmi3Status fmi3GetOutputDerivatives(void *c, const fmi3ValueReference r[], size_t n, const int32_t order[],
    double value[], size_t m) REFUSED
EXPORT fmi3Status fmi3EvaluateDiscreteStates(void *c) REFUSED
EXPORT fmi3Status fmi3UpdateDiscreteStates(void *c, bool *again, bool *terminate, bool *nominals, bool *values,
    bool *defined, double *time) REFUSED
EXPORT fmi3Status fmi3CompletedIntegratorStep(void *c, bool no_return, bool *event, bool *terminate) REFUSED
EXPORT fmi3Status fmi3SetTime(void *c, double time) REFUSED
EXPORT fmi3Status fmi3SetContinuousStates(void *c, const double value[], size_t n) REFUSED
EXPORT fmi3Status fmi3GetContinuousStates(void *c, double value[], size_t n) REFUSED
EXPORT fmi3Status fmi3GetContinuousStateDerivatives(void *c, double value[], size_t n) REFUSED
EXPORT fmi3Status fmi3GetEventIndicators(void *c, double value[], size_t n) REFUSED
EXPORT fmi3Status fmi3GetNominalsOfContinuousStates(void *c, double value[], size_t n) REFUSED
EXPORT fmi3Status fmi3GetNumberOfContinuousStates(void *c, size_t *n) REFUSED
EXPORT fmi3Status fmi3GetNumberOfEventIndicators(void *c, size_t *n) REFUSED
EXPORT fmi3Status fmi3GetIntervalDecimal(void *c, const fmi3ValueReference r[], size_t n, double value[], int q[]) REFUSED
EXPORT fmi3Status fmi3GetIntervalFraction(void *c, const fmi3ValueReference r[], size_t n, uint64_t count[],
    uint64_t resolution[], int q[]) REFUSED
EXPORT fmi3Status fmi3GetShiftDecimal(void *c, const fmi3ValueReference r[], size_t n, double value[]) REFUSED
EXPORT fmi3Status fmi3GetShiftFraction(void *c, const fmi3ValueReference r[], size_t n, uint64_t count[],
    uint64_t resolution[]) REFUSED
EXPORT fmi3Status fmi3SetIntervalDecimal(void *c, const fmi3ValueReference r[], size_t n, const double value[]) REFUSED
EXPORT fmi3Status fmi3SetIntervalFraction(void *c, const fmi3ValueReference r[], size_t n, const uint64_t count[],
    const uint64_t resolution[]) REFUSED
EXPORT fmi3Status fmi3SetShiftDecimal(void *c, const fmi3ValueReference r[], size_t n, const double value[]) REFUSED
EXPORT fmi3Status fmi3SetShiftFraction(void *c, const fmi3ValueReference r[], size_t n, const uint64_t count[],
    const uint64_t resolution[]) REFUSED
EXPORT fmi3Status fmi3ActivateModelPartition(void *c, fmi3ValueReference r, double time) REFUSED
