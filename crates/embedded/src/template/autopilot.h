/* @title@
 *
@about@
 */

#ifndef @PREFIX@_H
#define @PREFIX@_H

@include_stdint@
#ifdef __cplusplus
extern "C" {
#endif

typedef @real@ @prefix@_real;

#define @PREFIX@_SAMPLE_TIME @sample_time@ /* s between two ticks */
#define @PREFIX@_DELAY_TICKS @late@ /* a command comes out so many ticks after the one that computes it */
#define @PREFIX@_SPEED_MINIMUM @minimum@ /* m/s along the path: rho = -1 */
#define @PREFIX@_SPEED_MAXIMUM @maximum@ /* m/s along the path: rho = 1 */
#define @PREFIX@_GAMMA @gamma@ /* bound of the gain of the loop in continuous time */
#define @PREFIX@_CERTIFIED @certified@ /* 1: the bound was proved in exact arithmetic */
#define @PREFIX@_CERTIFICATE_SHA256 "@sha256@"
@stale_after@

/* What is measured and wanted, SI units. A reference that is not finite is refused. */
typedef struct {
@inputs@
@ages@
} @prefix@_inputs;

/* What comes out, held until the next tick. */
typedef struct {
@outputs@
    @prefix@_real scheduling_parameter; /* 1, -1 to 1: rho, -1 at the slowest and 1 at the fastest scheduled speed */
@trims@
@used@
    unsigned status; /* the sum of the bits below */
} @prefix@_outputs;

/* What the actuators get, in the units of the outputs. */
typedef struct {
@applied@
} @prefix@_commands;

/* Bits of the status. */
#define @PREFIX@_OUT_OF_RANGE 0x1u /* the measured speed is outside the scheduled range, and rho is held at its end */
#define @PREFIX@_SATURATED 0x2u /* a command that this tick computed was cut off at its limit; of which actuator: */
@saturated_bits@
#define @PREFIX@_REFERENCE_LIMITED 0x4u /* a reference is not used as it is asked: it is limited to the envelope, yields because an actuator stays at its limit, or returns after that or after following */
@lost_bits@

/* What a function returns. With any other than OK neither the state nor the outputs were touched: the last commands hold. */
enum {
    @PREFIX@_OK = 0,
    @PREFIX@_BAD_INPUT = 1, /* a reference or a command applied, at a reset any input, that cannot be: see above */
    @PREFIX@_SINGULAR = 2, /* the loop through rho has no solution */
    @PREFIX@_DIVERGED = 3 /* a command is infinite or not a number: an input was far too large; reset */
};

@way@
@sensors@

/* One autopilot. It is the caller's, and nothing else is kept anywhere; its members are not to be written. */
typedef struct {
@state@
} @prefix@_state;

/* Brings a new state to rest in level flight at the middle of the speeds. */
int @prefix@_init(@prefix@_state *state, @prefix@_outputs *out);

/* Restarts at the present inputs: the controller's state is zero, V_r what is wanted, and no tick was run. */
int @prefix@_reset(@prefix@_state *state, const @prefix@_inputs *in, @prefix@_outputs *out);

/* Runs one tick: to be called each @PREFIX@_SAMPLE_TIME seconds. */
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
