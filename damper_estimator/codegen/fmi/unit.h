/*
 * One instance of the damper behind both versions of FMI: values by reference, and one step.
 *
 * A step from t uses the inputs as the sample at t; the outputs are the estimates at t. Non-finite numbers, parameters
 * beyond their bounds and steps back in time are refused and leave the instance unchanged.
 */
#ifndef UNIT_H
#define UNIT_H

#include "config.h"
#include "damper.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT
#endif

/* Value references; the order of inputs and outputs is that of the description. */
enum { FIRST_INPUT = 1, FIRST_OUTPUT = 100, FIRST_INTEGER = 200, REACHED = 300, FIRST_PARAMETER = 1000 };
enum { DISPLACEMENT = 0, COMMAND, TEMPERATURE, PRESSURE, DESIRED_FORCE, INPUTS };
enum { OUTPUTS = 11, INTEGERS = 3 };
#define LATEST 2.0e9 /* s, well within the range of a stamp in ns */

typedef struct {
    damper_state state;
    double parameters[PARAMETERS];
    double inputs[INPUTS];
    double outputs[OUTPUTS];
    int32_t integers[INTEGERS];
    bool reached;
    bool begun;   /* a sample was taken */
    bool stepped; /* by a step, not only by the initialization */
    int64_t last;
    double start;
} unit;

static void unit_reset(unit *own)
{
    for (size_t i = 0; i < PARAMETERS; ++i) {
        own->parameters[i] = damper_parameters[i];
    }
    for (size_t i = 0; i < INPUTS; ++i) {
        own->inputs[i] = INPUT_START[i];
    }
    for (size_t i = 0; i < OUTPUTS; ++i) {
        own->outputs[i] = 0.0;
    }
    for (size_t i = 0; i < INTEGERS; ++i) {
        own->integers[i] = 0;
    }
    own->reached = false;
    own->begun = false;
    own->stepped = false;
    own->last = 0;
    own->start = 0.0;
    damper_init(&own->state);
    own->state.parameters = own->parameters;
}

static unit *unit_new(const char *token)
{
    unit *own = ((token != NULL) && (strcmp(token, TOKEN) == 0)) ? malloc(sizeof(unit)) : NULL;
    if (own != NULL) {
        unit_reset(own);
    }
    return own;
}

/* Restores a saved instance; the pointer to the parameters remains that of this instance. */
static void unit_restore(unit *own, const unit *saved)
{
    *own = *saved;
    own->state.parameters = own->parameters;
}

/* Value of a real by reference; false for an unknown reference. */
static bool unit_get(const unit *own, uint32_t reference, double *value)
{
    if ((reference >= FIRST_INPUT) && (reference < FIRST_INPUT + INPUTS)) {
        *value = own->inputs[reference - FIRST_INPUT];
    } else if ((reference >= FIRST_OUTPUT) && (reference < FIRST_OUTPUT + OUTPUTS)) {
        *value = own->outputs[reference - FIRST_OUTPUT];
    } else if ((reference >= FIRST_PARAMETER) && (reference - FIRST_PARAMETER < PARAMETERS)) {
        *value = own->parameters[reference - FIRST_PARAMETER];
    } else if (reference == 0U) {
        *value = own->begun ? (double)own->last / 1e9 : own->start;
    } else {
        return false;
    }
    return true;
}

static bool unit_set(unit *own, uint32_t reference, double value)
{
    const size_t parameter = (size_t)reference - FIRST_PARAMETER;
    if ((reference >= FIRST_INPUT) && (reference < FIRST_INPUT + INPUTS)) {
        own->inputs[reference - FIRST_INPUT] = value; /* checked by the step that uses it */
        return true;
    }
    if ((reference < FIRST_PARAMETER) || (parameter >= PARAMETERS) || !TUNABLE[parameter]) {
        return false;
    }
    if (!((value >= LOWEST[parameter]) && (value <= HIGHEST[parameter]))) {
        return false;
    }
    own->parameters[parameter] = value;
    return true;
}

static bool unit_get_integer(const unit *own, uint32_t reference, int32_t *value)
{
    if ((reference < FIRST_INTEGER) || (reference >= FIRST_INTEGER + INTEGERS)) {
        return false;
    }
    *value = own->integers[reference - FIRST_INTEGER];
    return true;
}

/* Processes the inputs as the sample at a time in s; false for invalid inputs. */
static bool unit_sample(unit *own, double time)
{
    damper_input in = { 0 };
    damper_output out = { 0 };
    if (!(fabs(time) < LATEST)) {
        return false;
    }
    in.stamp = (int64_t)llround(time * 1e9);
    if (own->begun && (in.stamp < own->last)) {
        return false;
    }
    for (size_t i = 0; i < INPUTS; ++i) {
        if (IS_INPUT[i] && !isfinite(own->inputs[i])) {
            return false;
        }
    }
    if (!(fabs(own->inputs[DISPLACEMENT]) < 1e6)) {
        return false;
    }
    in.displacement = own->inputs[DISPLACEMENT];
    in.command = own->inputs[COMMAND];
    in.command_arrived = IS_INPUT[COMMAND] ? 1 : 0;
    in.temperature = own->inputs[TEMPERATURE];
    in.temperature_arrived = IS_INPUT[TEMPERATURE] ? 1 : 0;
    in.pressure = own->inputs[PRESSURE];
    in.pressure_arrived = IS_INPUT[PRESSURE] ? 1 : 0;
    in.reach = INVERTS;
    if (damper_step(&own->state, &in, &out) < DAMPER_DUPLICATE) {
        const double numbers[OUTPUTS - 2] = { out.displacement, out.velocity, out.acceleration, out.force,
            out.force_stddev, out.force_min, out.force_max, out.dforce_dvelocity, out.dforce_dcurrent };
        for (size_t i = 0; i < OUTPUTS - 2; ++i) {
            own->outputs[i] = isfinite(numbers[i]) ? numbers[i] : 0.0; /* simulators stop at NaN */
        }
        own->integers[0] = out.status;
        own->integers[1] = out.trusted;
    }
    own->integers[2] = out.verdict;
#if INVERTS
    damper_answer answer;
    damper_inverse(&own->state, own->inputs[DESIRED_FORCE], &answer);
    own->outputs[OUTPUTS - 2] = isfinite(answer.current) ? answer.current : 0.0;
    own->outputs[OUTPUTS - 1] = isfinite(answer.expected) ? answer.expected : 0.0;
    own->reached = answer.reached != 0;
#endif
    own->begun = true;
    own->last = in.stamp;
    return true;
}

/* A communication step of a length in s from a time. */
static bool unit_step(unit *own, double time, double length)
{
    if (!((length >= 0.0) && (length < LATEST))) {
        return false;
    }
    if (own->begun && !own->stepped) { /* the sample of the first step replaces that of the initialization */
        damper_reset(&own->state);
    }
    if (!unit_sample(own, time)) {
        return false;
    }
    own->stepped = true;
    return true;
}

#endif
