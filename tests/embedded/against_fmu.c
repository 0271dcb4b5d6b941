/* Runs the same random ticks in the source and in the controller's FMU, and stops at the first bit that differs:
 *
 *     against_fmu LIBRARY GUID RESOURCE_URI COUNT OUT_OF_RANGE REFERENCE_LIMITED STATUS STALE_AFTER REFERENCE...
 *
 * REFERENCE are the value references of the inputs, the last of them whether each measurement is valid, then of the outputs, in
 * the order of the structs; the others are those of the outputs and the parameter of their names. Prints the hash, and how often
 * each code came, resets, limited commands, speeds out of range, limited references, a lost sensor, and safe commands. */

#define _POSIX_C_SOURCE 200809L
#include "ticks.h"
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

typedef void *Component;
typedef unsigned Reference;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
static int (*setup)(Component, int, double, double, int, double);
static int (*enter)(Component), (*leave)(Component), (*reset)(Component);
static int (*set_real)(Component, const Reference *, size_t, const double *);
static int (*get_real)(Component, const Reference *, size_t, double *);
static int (*set_boolean)(Component, const Reference *, size_t, const int *);
static int (*get_boolean)(Component, const Reference *, size_t, int *);
static int (*get_integer)(Component, const Reference *, size_t, int *);
static int (*do_step)(Component, double, double, int);

enum { WARNING = 1, ERROR = 3 };
/* The inputs that are numbers in the FMU, and the first argument that is a reference of one. */
enum { NUMBERS = INPUTS - SENSORS, FIRST = 9 };

static void refuse(const char *what, long tick)
{
    fprintf(stderr, "tick %ld: %s\n", tick, what);
    exit(1);
}

static void require(int is_so, const char *what, long tick)
{
    if (!is_so) refuse(what, tick);
}

static void logger(void *environment, const char *name, int status, const char *category, const char *text, ...)
{
    (void)environment, (void)name, (void)status, (void)category, (void)text;
}

/* A data pointer does not convert to a function pointer in ISO C; its bytes do. */
static void symbol(void *library, const char *name, void *function)
{
    void *address = dlsym(library, name);
    require(address != NULL, name, 0);
    memcpy(function, &address, sizeof address);
}

static void load(const char *path)
{
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    require(library != NULL, "the library does not load", 0);
    symbol(library, "fmi2Instantiate", &instantiate);
    symbol(library, "fmi2SetupExperiment", &setup);
    symbol(library, "fmi2EnterInitializationMode", &enter);
    symbol(library, "fmi2ExitInitializationMode", &leave);
    symbol(library, "fmi2Reset", &reset);
    symbol(library, "fmi2SetReal", &set_real);
    symbol(library, "fmi2GetReal", &get_real);
    symbol(library, "fmi2SetBoolean", &set_boolean);
    symbol(library, "fmi2GetBoolean", &get_boolean);
    symbol(library, "fmi2GetInteger", &get_integer);
    symbol(library, "fmi2DoStep", &do_step);
}

/* The number of the status in the FMU. */
static int status_of(unsigned bits)
{
    if (bits & 8u) return 5;
    if (bits & RECKONED) return 4;
    if (bits & LOST_SPEED) return 3;
    return bits & 6u ? 2 : 1;
}

/* The outputs, to the bit, and what the status says. */
static void compare(Component c, const Ticks *t, const Reference *outputs, const Reference *flags, long tick)
{
    double expected[OUTPUTS];
    OF(real) found[OUTPUTS];
    int is_set[2] = {-1, -1}, status = -1;
    const unsigned bits = t->out.status;
    require(get_real(c, outputs, OUTPUTS, expected) <= WARNING, "fmi2GetReal", tick);
    require(get_boolean(c, flags, 2, is_set) <= WARNING, "fmi2GetBoolean", tick);
    require(get_integer(c, flags + 2, 1, &status) <= WARNING, "fmi2GetInteger", tick);
    memcpy(found, &t->out, sizeof found);
    for (int i = 0; i < OUTPUTS; i++) {
        if (memcmp(&expected[i], &found[i], sizeof *expected) == 0) continue;
        fprintf(stderr, "output %d is %.17g, and of the FMU %.17g\n", i, (double)found[i], expected[i]);
        refuse("the source is not the FMU", tick);
    }
    require(status_of(bits) == status, "the status is not that of the FMU", tick);
    if (bits & 8u) return; /* All but the commands holds, and the status says only what is lost. */
    require((bits & 1u) == (unsigned)is_set[0], "the status does not say that the speed is out of range", tick);
    require((bits >> 2 & 1u) == (unsigned)is_set[1], "the status does not say that a reference is limited", tick);
}

int main(int argc, char **argv)
{
    static const Callbacks callbacks = {logger, calloc, free, NULL, NULL};
    static Ticks t;
    Reference in[INPUTS], out[OUTPUTS];
    require(argc == FIRST + INPUTS + OUTPUTS, "wrong number of arguments", 0);
    for (int i = 0; i < INPUTS; i++) in[i] = (Reference)strtoul(argv[FIRST + i], NULL, 10);
    for (int i = 0; i < OUTPUTS; i++) out[i] = (Reference)strtoul(argv[FIRST + INPUTS + i], NULL, 10);
    Reference flags[4];
    for (int i = 0; i < 4; i++) flags[i] = (Reference)strtoul(argv[5 + i], NULL, 10);
    const double stale_after = STALE_AFTER;
    const long count = strtol(argv[4], NULL, 10);
    load(argv[1]);
    const Component c = instantiate("c", 1, argv[2], argv[3], &callbacks, 0, 0);
    require(c != NULL, "fmi2Instantiate", 0);

    begin(&t);
    double since = 0.0;
    for (long tick = 0, first = 1; tick < count; tick++) {
        int was_reset;
        double inputs[INPUTS];
        const int code = run(&t, &was_reset);
        memcpy(inputs, &t.in, sizeof inputs);
        if (was_reset) {
            if (!first) require(reset(c) == 0, "fmi2Reset", tick);
            first = 0;
            since = 0.0;
            require(setup(c, 0, 0.0, 0.0, 0, 0.0) == 0 && enter(c) <= WARNING, "no initialization", tick);
            require(set_real(c, flags + 3, 1, &stale_after) <= WARNING, "stale_after", tick);
        }
        require(set_real(c, in, SENSORS, inputs) <= WARNING, "fmi2SetReal", tick);
        const int set = set_real(c, in + SENSORS, NUMBERS - SENSORS, inputs + SENSORS);
        int is_finite = 1;
        for (int i = SENSORS; i < NUMBERS; i++) is_finite &= inputs[i] - inputs[i] == 0.0;
        int valid[SENSORS];
        for (int i = 0; i < SENSORS; i++) valid[i] = inputs[NUMBERS + i] >= 0.0 && inputs[NUMBERS + i] <= stale_after;
        require(set_boolean(c, in + NUMBERS, SENSORS, valid) <= WARNING, "fmi2SetBoolean", tick);
        require((set > WARNING) == !is_finite, "the FMU does not refuse what is no number", tick);
        /* While the commands go to the safe ones no reference is used. */
        require((code == BAD_INPUT) == (!is_finite && (was_reset || !(t.out.status & 8u))), "the two do not refuse alike", tick);
        if (code == BAD_INPUT) continue; /* Both are as they were. */
        int status = was_reset ? leave(c) : do_step(c, since * SAMPLE_TIME, SAMPLE_TIME, 1);
        require((status > WARNING) == (code != OK), "the two do not fail at the same ticks", tick);
        since += was_reset ? 0.0 : 1.0;
        if (code == OK) compare(c, &t, out, flags, tick);
    }
    printf("%016llx", (unsigned long long)t.hash);
    for (int code = 0; code < 4; code++) printf(" %ld", t.codes[code]);
    printf(" %ld %ld %ld %ld %ld %ld\n", t.resets, t.limited, t.outside, t.beyond, t.lost, t.failed);
    fflush(stdout);
    _Exit(0);
}
