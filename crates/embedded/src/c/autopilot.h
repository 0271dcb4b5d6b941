/* @title@
 *
@about@
 */

#ifndef AUTOPILOT_H
#define AUTOPILOT_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef @real@ autopilot_real;

#define AUTOPILOT_SAMPLE_TIME @sample_time@ /* s, period of the ticks */
#define AUTOPILOT_DELAY_TICKS @late@ /* ticks from the computation of a command to its output */
#define AUTOPILOT_SPEED_MINIMUM @minimum@ /* m/s along the path: rho = -1 */
#define AUTOPILOT_SPEED_MAXIMUM @maximum@ /* m/s along the path: rho = 1 */
#define AUTOPILOT_GAMMA @gamma@ /* bound on the gain of the loop in continuous time */
#define AUTOPILOT_CERTIFIED @certified@ /* 1 if the bound was proved in exact arithmetic */
#define AUTOPILOT_CERTIFICATE_SHA256 "@sha256@"
@stale_after@

/* Measurements and references, SI units. A reference that is not finite is rejected. */
typedef struct {
@inputs@
@ages@
} autopilot_inputs;

/* Outputs, held until the next tick. */
typedef struct {
@outputs@
    autopilot_real scheduling_parameter; /* 1, -1 to 1: rho, -1 at the lowest and 1 at the highest scheduled speed */
@trims@
@used@
    unsigned status; /* the sum of the bits below */
} autopilot_outputs;

/* Commands applied to the actuators, in the units of the outputs. */
typedef struct {
@applied@
} autopilot_commands;

/* Bits of the status. */
#define AUTOPILOT_OUT_OF_RANGE 0x1u /* the measured speed is outside the scheduled range; rho is held at its bound */
#define AUTOPILOT_SATURATED 0x2u /* a command computed at this tick was limited; the bits of the actuators: */
@saturated_bits@
#define AUTOPILOT_REFERENCE_LIMITED 0x4u /* a reference differs from its input: it is limited to the envelope, yields because an actuator stays at its limit, or returns after that or after following */
@lost_bits@

/* Return codes. With any code but OK neither the state nor the outputs are changed: the last commands hold. */
enum {
    AUTOPILOT_OK = 0,
    AUTOPILOT_BAD_INPUT = 1, /* a reference, an applied command or, at a reset, any input is out of bounds: see above */
    AUTOPILOT_SINGULAR = 2, /* the algebraic loop through rho has no solution */
    AUTOPILOT_DIVERGED = 3 /* a command is infinite or NaN: an input was far too large; reset */
};

/* The transition of a reference to its input. */
typedef struct {
    autopilot_real start, rate; /* value at the start, advanced at the rate at the start */
    autopilot_real share, lag; /* 1: weight of the start in the reference; exp(-t/1 s) */
} autopilot_transition;

#ifdef AUTOPILOT_FAILED
/* Monitor of a sensor; times in ticks. */
typedef struct {
    autopilot_real last;
    autopilot_real believed; /* the last value, or the estimate without the sensor */
    autopilot_real mean;
    autopilot_real moved; /* expected change since its value changed or while it agrees */
    autopilot_real anchor; /* effect of the commands when its value changed */
    uint32_t same, lost_for, plausible_for, wrong_for;
} autopilot_watched;

/* The sensors, in the order of the inputs, and the ramp to the safe commands. */
typedef struct {
    autopilot_watched watched[@measurements@];
    autopilot_real from[@commands@];
    uint32_t failed_for;
    int changed, judged;
} autopilot_sensors;
#endif

/* State of one autopilot, owned by the caller. There is no other state; do not write its members. */
typedef struct {
    autopilot_real x[@states@]; /* state of the controller */
    autopilot_real filtered_speed; /* m/s: V_r, the filtered speed reference */
    autopilot_real last[@references@]; /* references used at the last tick, in the order of the inputs */
    autopilot_transition way[@references@]; /* of each reference to its input */
    autopilot_real put_out[@commands@]; /* last commands output, before the curves */
    autopilot_real anchor[@commands@]; /* commands applied when it last followed */
    int followed_for; /* ticks since then */
    int held[@commands@]; /* 2 n, plus 1 while beyond the limit; n counts the ticks beyond it, less those since */
@origins@
#if AUTOPILOT_DELAY_TICKS > 0
    autopilot_real waiting[AUTOPILOT_DELAY_TICKS][@commands@]; /* delayed commands */
    int next; /* index of those output at the next tick */
#endif
#ifdef AUTOPILOT_FAILED
    autopilot_sensors sensors;
#endif
} autopilot_state;

/* Initialises a state at rest in level flight at the middle of the speed range. */
int autopilot_init(autopilot_state *state, autopilot_outputs *out);

/* Restarts at the given inputs: the controller state is zero, V_r is the speed reference, and no tick is run. */
int autopilot_reset(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out);

/* Runs one tick; call it every AUTOPILOT_SAMPLE_TIME seconds. */
int autopilot_step(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out);

/* Sets the state so that the next step outputs the applied commands of others; call it before step. */
int autopilot_follow(autopilot_state *state, const autopilot_inputs *in, const autopilot_commands *applied);

/* Informs the anti-windup of commands applied since the last step that differ from the outputs; call it before step. */
int autopilot_feed_back(autopilot_state *state, const autopilot_commands *applied);

#ifdef AUTOPILOT_FAILED
/* Writes the safe commands, which are output at the end of the ramp of FAILED. */
void autopilot_safe(autopilot_commands *out);
#endif

#ifdef __cplusplus
}
#endif

#endif
