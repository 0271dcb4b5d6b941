/* Random ticks of an autopilot that `squid export` wrote: the same ones on every machine, and a hash of what comes out.
 *
 * Given by the compiler's options: HEADER, the header of the autopilot; OF(name), what its names begin with; MIDDLE and SIZES,
 * for each input a value in the middle and how far it moves; SENSORS, the number of measurements, which come first among the
 * inputs, and their ages last. No product is added to anything in one expression that the
 * hash depends on, so that no compiler can fuse the two. */

#include HEADER
#include <stdint.h>
#if __STDC_HOSTED__
#include <string.h>
#else
#include <stddef.h>
void *memcpy(void *restrict to, const void *restrict from, size_t size);
void *memset(void *to, int byte, size_t size);
#endif

enum {
    INPUTS = sizeof(OF(inputs)) / sizeof(OF(real)),
    OUTPUTS = (sizeof(OF(outputs)) - sizeof(unsigned)) / sizeof(OF(real))
};
/* As the header has them. */
enum { OK = 0, BAD_INPUT = 1, SINGULAR = 2, DIVERGED = 3 };

typedef struct {
    uint64_t random, hash;
    double common, own[INPUTS], value[INPUTS];
    int to_reset, is_first, reset_in, is_calm;
    OF(state) state;
    OF(inputs) in;
    OF(outputs) out;
    long codes[4], resets, limited, outside, beyond, lost, failed;
} Ticks;

/* G. L. Steele and others, Fast splittable pseudorandom number generators, 2014. */
static uint64_t random_number(Ticks *t)
{
    uint64_t z = t->random += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static int one_of(Ticks *t, unsigned count) { return random_number(t) % count == 0; }

/* A multiple of 2^-30 from -1 to 1. */
static double part(Ticks *t) { return (double)((int64_t)(random_number(t) >> 33) - (1 << 30)) / (1 << 30); }

/* The next inputs: all go towards goals in common, each with a small part of its own, which change now and then; some lie
 * far beyond the range of speed; for a third of the time they stay in the middle, and so they begin. Rarely one is too
 * large, or a reference no number or infinite; after one that is too large a reset follows soon. An age is above the
 * limit or below zero now and then. */
static void next_inputs(Ticks *t)
{
    static const double middle[INPUTS] = MIDDLE, sizes[INPUTS] = SIZES;
    double taken[INPUTS];
    const int begins = t->to_reset || t->is_first;
    if (begins) memcpy(t->value, middle, sizeof middle);
    if (one_of(t, 200)) t->common = part(t) * (one_of(t, 20) ? 16.0 : 1.0);
    if (one_of(t, 3000)) t->is_calm = one_of(t, 3);
    for (int i = 0; i < INPUTS; i++) {
        if (one_of(t, 200)) t->own[i] = part(t) / (one_of(t, 5) ? 1.0 : 16.0);
        const double goal = t->is_calm || begins ? 0.0 : t->common + t->own[i], away = sizes[i] * goal, noise = sizes[i] * part(t);
        t->value[i] += (middle[i] + away - t->value[i]) / 16.0;
        taken[i] = t->value[i] + noise / 256.0;
    }
    if (one_of(t, 500) && !begins) {
        const double zero = 0.0, odd[] = {zero / zero, 1.0 / zero, -1.0 / zero, 1e6, 1.7e308};
        const unsigned which = random_number(t) % 5;
        const int place = (int)(random_number(t) % (INPUTS - SENSORS));
        if (which > 2 || place >= SENSORS) taken[place] = odd[which];
        if (which > 2) t->reset_in = 20;
    }
    OF(real) numbers[INPUTS];
    for (int i = 0; i < INPUTS; i++) numbers[i] = (OF(real))taken[i];
    memcpy(&t->in, numbers, sizeof t->in);
}

static void add(Ticks *t, uint64_t word)
{
    for (int i = 0; i < 8; i++, word >>= 8) t->hash = (t->hash ^ (word & 0xff)) * 0x100000001b3u; /* FNV-1a */
}

static void begin(Ticks *t)
{
    static const double middle[INPUTS] = MIDDLE;
    memset(t, 0, sizeof *t);
    t->hash = 0xcbf29ce484222325u;
    memcpy(t->value, middle, sizeof middle);
    OF(init)(&t->state, &t->out);
    t->to_reset = 1;
}

/* Resets or steps, and returns the code; `was_reset` says which. The first step after a reset takes its bearings anew, as the
 * FMU does. */
static int run(Ticks *t, int *was_reset)
{
    t->to_reset |= one_of(t, 5000) || t->reset_in == 1;
    t->reset_in -= t->reset_in > 0;
    next_inputs(t);
    *was_reset = t->to_reset;
    int code = OK;
    if (t->to_reset || t->is_first) code = OF(reset)(&t->state, &t->in, &t->out);
    if (code == OK && !t->to_reset) code = OF(step)(&t->state, &t->in, &t->out);
    t->is_first = t->to_reset && code == OK;
    t->to_reset = code == DIVERGED || code == SINGULAR;
    t->codes[code]++;
    t->resets += *was_reset;
    t->limited += (t->out.status & 2u) != 0;
    t->outside += (t->out.status & 1u) != 0;
    t->beyond += (t->out.status & 4u) != 0;
    t->lost += (t->out.status & 0xfff0u) != 0;
    t->failed += (t->out.status & 8u) != 0;
    OF(real) numbers[OUTPUTS];
    memcpy(numbers, &t->out, sizeof numbers);
    add(t, (uint64_t)code);
    for (int i = 0; i < OUTPUTS; i++) {
        const double wide = (double)numbers[i];
        uint64_t bits;
        memcpy(&bits, &wide, sizeof bits);
        add(t, bits);
    }
    add(t, t->out.status);
    return code;
}
