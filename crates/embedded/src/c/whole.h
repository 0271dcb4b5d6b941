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

#define AUTOPILOT_SAMPLE_TIME @sample_time@ /* s between two ticks, of every axis */

/* What is measured and wanted, SI units: what any axis takes. */
typedef struct {
@inputs@
} autopilot_inputs;

/* What comes out, held until the next tick. */
typedef struct {
@outputs@
} autopilot_outputs;

/* What the actuators get, in the units of the outputs. */
typedef struct {
@commands@
} autopilot_commands;

/* What a function returns: that of the first axis that returns another than OK. */
enum {
    AUTOPILOT_OK = 0,
    AUTOPILOT_BAD_INPUT = 1,
    AUTOPILOT_SINGULAR = 2,
    AUTOPILOT_DIVERGED = 3
};

/* One autopilot. It is the caller's, and nothing else is kept anywhere; its members are not to be written. */
typedef struct {
@states@
} autopilot_state;

/* Brings a new state to rest in level flight at the middle of the speeds of each axis. */
int autopilot_init(autopilot_state *state, autopilot_outputs *out);

/* Restarts at the present inputs; of all axes or, with any other than OK, of none. */
int autopilot_reset(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out);

/* Runs one tick of each axis: to be called each AUTOPILOT_SAMPLE_TIME seconds. */
int autopilot_step(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out);

/* Brings the state to where the next step commands what is applied by others: to be called before step. */
int autopilot_follow(autopilot_state *state, const autopilot_inputs *in, const autopilot_commands *applied);

/* Tells the anti-windup what the actuators got since the last step, where that is not what came out: before step. */
int autopilot_feed_back(autopilot_state *state, const autopilot_commands *applied);

@safe@

#ifdef __cplusplus
}
#endif

#endif
