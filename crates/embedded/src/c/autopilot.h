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

#define AUTOPILOT_SAMPLE_TIME @sample_time@ /* s between two ticks */
#define AUTOPILOT_DELAY_TICKS @late@ /* a command comes out so many ticks after the one that computes it */
#define AUTOPILOT_SPEED_MINIMUM @minimum@ /* m/s along the path: rho = -1 */
#define AUTOPILOT_SPEED_MAXIMUM @maximum@ /* m/s along the path: rho = 1 */
#define AUTOPILOT_GAMMA @gamma@ /* bound of the gain of the loop in continuous time */
#define AUTOPILOT_CERTIFIED @certified@ /* 1: the bound was proved in exact arithmetic */
#define AUTOPILOT_CERTIFICATE_SHA256 "@sha256@"
@stale_after@

/* What is measured and wanted, SI units. A reference that is not finite is refused. */
typedef struct {
@inputs@
@ages@
} autopilot_inputs;

/* What comes out, held until the next tick. */
typedef struct {
@outputs@
    autopilot_real scheduling_parameter; /* 1, -1 to 1: rho, -1 at the slowest and 1 at the fastest scheduled speed */
@trims@
@used@
    unsigned status; /* the sum of the bits below */
} autopilot_outputs;

/* What the actuators get, in the units of the outputs. */
typedef struct {
@applied@
} autopilot_commands;

/* Bits of the status. */
#define AUTOPILOT_OUT_OF_RANGE 0x1u /* the measured speed is outside the scheduled range, and rho is held at its end */
#define AUTOPILOT_SATURATED 0x2u /* a command that this tick computed was cut off at its limit; of which actuator: */
@saturated_bits@
#define AUTOPILOT_REFERENCE_LIMITED 0x4u /* a reference is not used as it is asked: it is limited to the envelope, yields because an actuator stays at its limit, or returns after that or after following */
@lost_bits@

/* What a function returns. With any other than OK neither the state nor the outputs were touched: the last commands hold. */
enum {
    AUTOPILOT_OK = 0,
    AUTOPILOT_BAD_INPUT = 1, /* a reference or a command applied, at a reset any input, that cannot be: see above */
    AUTOPILOT_SINGULAR = 2, /* the loop through rho has no solution */
    AUTOPILOT_DIVERGED = 3 /* a command is infinite or not a number: an input was far too large; reset */
};

/* The way of a reference to what is asked. */
typedef struct {
    autopilot_real start, rate; /* where it began, moved on by the rate at which it did */
    autopilot_real share, lag; /* 1: the share of the start in the reference; exp(-t/1 s) */
} autopilot_transition;

#ifdef AUTOPILOT_FAILED
/* What is known of a sensor; times in ticks. */
typedef struct {
    autopilot_real last;
    autopilot_real believed; /* the last value, or what is expected without it */
    autopilot_real mean;
    autopilot_real moved; /* by so much it should have, since its value changed or while it agrees */
    autopilot_real anchor; /* what the commands gave when its value changed */
    uint32_t same, lost_for, plausible_for, wrong_for;
} autopilot_watched;

/* The sensors, in the order of the inputs, and the way to the safe commands. */
typedef struct {
    autopilot_watched watched[@measurements@];
    autopilot_real from[@commands@];
    uint32_t failed_for;
    int changed, judged;
} autopilot_sensors;
#endif

/* One autopilot. It is the caller's, and nothing else is kept anywhere; its members are not to be written. */
typedef struct {
    autopilot_real x[@states@]; /* state of the controller */
    autopilot_real filtered_speed; /* m/s: V_r, the filtered reference of the speed */
    autopilot_real last[@references@]; /* the references as they were used last, in the order of the inputs */
    autopilot_transition way[@references@]; /* of each to what is asked */
    autopilot_real put_out[@commands@]; /* commands that came out last, before curves */
    autopilot_real anchor[@commands@]; /* what was applied when it followed last */
    int followed_for; /* ticks since then */
    int held[@commands@]; /* twice the ticks for which each command was beyond its limit, less those since, and 1 if it is */
@origins@
#if AUTOPILOT_DELAY_TICKS > 0
    autopilot_real waiting[AUTOPILOT_DELAY_TICKS][@commands@]; /* commands that are still to come out */
    int next; /* which of them comes out at the next tick */
#endif
#ifdef AUTOPILOT_FAILED
    autopilot_sensors sensors;
#endif
} autopilot_state;

/* Brings a new state to rest in level flight at the middle of the speeds. */
int autopilot_init(autopilot_state *state, autopilot_outputs *out);

/* Restarts at the present inputs: the controller's state is zero, V_r what is wanted, and no tick was run. */
int autopilot_reset(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out);

/* Runs one tick: to be called each AUTOPILOT_SAMPLE_TIME seconds. */
int autopilot_step(autopilot_state *state, const autopilot_inputs *in, autopilot_outputs *out);

/* Brings the state to where the next step commands what is applied by others: to be called before step. */
int autopilot_follow(autopilot_state *state, const autopilot_inputs *in, const autopilot_commands *applied);

/* Tells the anti-windup what the actuators got since the last step, where that is not what came out: before step. */
int autopilot_feed_back(autopilot_state *state, const autopilot_commands *applied);

#ifdef AUTOPILOT_FAILED
/* The commands that FAILED goes to. */
void autopilot_safe(autopilot_commands *out);
#endif

#ifdef __cplusplus
}
#endif

#endif
