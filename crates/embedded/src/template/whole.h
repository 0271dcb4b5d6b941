/* @title@
 *
@about@
 */

#ifndef @PREFIX@_H
#define @PREFIX@_H

@includes@
#ifdef __cplusplus
extern "C" {
#endif

typedef @real@ @prefix@_real;

#define @PREFIX@_SAMPLE_TIME @sample_time@ /* s between two ticks, of every axis */

/* What is measured and wanted, SI units: what any axis takes. */
typedef struct {
@inputs@
} @prefix@_inputs;

/* What comes out, held until the next tick. */
typedef struct {
@outputs@
} @prefix@_outputs;

/* What the actuators get, in the units of the outputs. */
typedef struct {
@commands@
} @prefix@_commands;

/* What a function returns: that of the first axis that returns another than OK. */
enum {
    @PREFIX@_OK = 0,
    @PREFIX@_BAD_INPUT = 1,
    @PREFIX@_SINGULAR = 2,
    @PREFIX@_DIVERGED = 3
};

/* One autopilot. It is the caller's, and nothing else is kept anywhere; its members are not to be written. */
typedef struct {
@states@
} @prefix@_state;

/* Brings a new state to rest in level flight at the middle of the speeds of each axis. */
int @prefix@_init(@prefix@_state *state, @prefix@_outputs *out);

/* Restarts at the present inputs; of all axes or, with any other than OK, of none. */
int @prefix@_reset(@prefix@_state *state, const @prefix@_inputs *in, @prefix@_outputs *out);

/* Runs one tick of each axis: to be called each @PREFIX@_SAMPLE_TIME seconds. */
int @prefix@_step(@prefix@_state *state, const @prefix@_inputs *in, @prefix@_outputs *out);

/* Brings the state to where the next step commands what is applied by others: to be called before step. */
int @prefix@_follow(@prefix@_state *state, const @prefix@_inputs *in, const @prefix@_commands *applied);

/* Tells the anti-windup what the actuators got since the last step, where that is not what came out: before step. */
int @prefix@_feed_back(@prefix@_state *state, const @prefix@_commands *applied);

@safe@

#ifdef __cplusplus
}
#endif

#endif
