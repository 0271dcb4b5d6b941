/* @title@
 *
@about@
 */

#ifndef AUTOPILOT_H
#define AUTOPILOT_H

@includes@
#ifdef __cplusplus
extern "C" {
#endif

typedef @real@ autopilot_real;

#define AUTOPILOT_SAMPLE_TIME @sample_time@ /* s, period of the ticks of every axis */

/* Measurements and references of all axes, SI units. */
typedef struct {
@inputs@
} autopilot_inputs;

/* Outputs, held until the next tick. */
typedef struct {
@outputs@
} autopilot_outputs;

/* Commands applied to the actuators, in the units of the outputs. */
typedef struct {
@commands@
} autopilot_commands;

/* Return codes: the code of the first axis that does not return OK. */
enum {
    AUTOPILOT_OK = 0,
    AUTOPILOT_BAD_INPUT = 1,
    AUTOPILOT_SINGULAR = 2,
    AUTOPILOT_DIVERGED = 3
};

/* State of one autopilot, owned by the caller. There is no other state; do not write its members. */
typedef struct {
@states@
} autopilot_state;

/* Initialises a state at rest in level flight at the middle of the speed range of each axis. */
int autopilot_init(autopilot_state *state, autopilot_outputs *out);

/* Restarts all axes at the given inputs or, with any code but OK, none. */
int autopilot_reset(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out);

/* Runs one tick of each axis; call it every AUTOPILOT_SAMPLE_TIME seconds. */
int autopilot_step(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out);

/* Sets the state so that the next step outputs the applied commands of others; call it before step. */
int autopilot_follow(autopilot_state *state, const autopilot_inputs *in, const autopilot_commands *applied);

/* Informs the anti-windup of commands applied since the last step that differ from the outputs; call it before step. */
int autopilot_feed_back(autopilot_state *state, const autopilot_commands *applied);

@safe@

#ifdef __cplusplus
}
#endif

#endif
