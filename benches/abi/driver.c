/* Times an FMI 2.0 co-simulation binary through its C ABI: `driver LIBRARY GUID RESOURCE_URI STEP COUNT ROUNDS INPUTS OUTPUTS`.
 *
 * INPUTS and OUTPUTS are value references with commas between. A round is COUNT times set, step, get, with inputs that change
 * each time, from a fresh start. Prints the median over the rounds of nanoseconds per step, and the outputs at the end. */

#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;
typedef void *(*Instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
typedef int (*Setup)(void *, int, double, double, int, double);
typedef int (*Plain)(void *);
typedef int (*SetReal)(void *, const unsigned *, size_t, const double *);
typedef int (*GetReal)(void *, const unsigned *, size_t, double *);
typedef int (*DoStep)(void *, double, double, int);

enum { FEWEST = 5, MOST = 16, ROUNDS = 101 };

/* Pitch, speed, pitch rate and the references of the first two at the initialisation, which sets the filtered reference;
 * further inputs are angles. */
static const double FIRST[MOST] = {0.0, 1.0, 0.0, 0.0, 1.0};

static void fail(const char *what) {
    fprintf(stderr, "driver: %s\n", what);
    exit(1);
}

static void logger(void *e, const char *name, int status, const char *category, const char *text, ...) {
    va_list more;
    (void)e, (void)name, (void)category;
    fprintf(stderr, "[%d] ", status);
    va_start(more, text);
    vfprintf(stderr, text, more);
    va_end(more);
    fputc('\n', stderr);
}

static void *symbol(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (found == NULL) fail(name);
    return found;
}

static size_t references(const char *text, unsigned *found) {
    size_t count = 0;
    for (char *end = (char *)text; *text != '\0' && count < MOST; text = *end == ',' ? end + 1 : end)
        found[count++] = (unsigned)strtoul(text, &end, 10);
    return count;
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t); /* not the time that others have the processor */
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static int rising(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(int argc, char **argv) {
    if (argc != 9) fail("LIBRARY GUID RESOURCE_URI STEP COUNT ROUNDS INPUTS OUTPUTS");
    void *library = dlopen(argv[1], RTLD_NOW | RTLD_GLOBAL);
    if (library == NULL) fail(dlerror());
    const Instantiate instantiate = (Instantiate)symbol(library, "fmi2Instantiate");
    const Setup setup = (Setup)symbol(library, "fmi2SetupExperiment");
    const Plain enter = (Plain)symbol(library, "fmi2EnterInitializationMode");
    const Plain leave = (Plain)symbol(library, "fmi2ExitInitializationMode");
    const SetReal set = (SetReal)symbol(library, "fmi2SetReal");
    const GetReal get = (GetReal)symbol(library, "fmi2GetReal");
    const DoStep step = (DoStep)symbol(library, "fmi2DoStep");
    const double size = strtod(argv[4], NULL);
    const long count = strtol(argv[5], NULL, 10), rounds = strtol(argv[6], NULL, 10);
    unsigned in[MOST], out[MOST];
    const size_t ins = references(argv[7], in), outs = references(argv[8], out);
    if (ins < FEWEST || outs == 0 || rounds < 1 || rounds > ROUNDS) fail("5 inputs or more, some outputs, 1 to 101 rounds");

    double taken[ROUNDS], values[MOST] = {0};
    const Callbacks callbacks = {logger, calloc, free, NULL, NULL};
    for (long round = 0; round < rounds; round++) {
        char name[32];
        snprintf(name, sizeof name, "round%ld", round);
        void *c = instantiate(name, 1, argv[2], argv[3], &callbacks, 0, 0);
        if (c == NULL) fail("fmi2Instantiate");
        if (setup(c, 0, 0.0, 0.0, 0, 0.0) > 1 || enter(c) > 1 || set(c, in, ins, FIRST) > 1 || leave(c) > 1)
            fail("initialisation");
        int worst = 0;
        const double begin = now();
        for (long k = 0; k < count; k++) {
            /* A bounded, ever changing course of the inputs, with references within their limits and measurements that no
             * vehicle is too slow for; cheap beside a step. */
            const double a = (double)(k % 101) / 101.0, b = 1.0 - fabs((double)(k % 74) / 37.0 - 1.0);
            const double v = 1.0 + 0.5 * (1.0 - fabs((double)(k % 100) / 50.0 - 1.0)); /* The mean of the speed. */
            double inputs[MOST] = {0.05 * (a - 0.5), 1.0 + 0.5 * b, 0.05 * (a - b), 0.05 * (b - 0.5), v};
            for (size_t i = FEWEST; i < ins; i++) inputs[i] = 0.05 * (b - a);
            worst |= set(c, in, ins, inputs) | step(c, (double)k * size, size, 1) | get(c, out, outs, values);
        }
        taken[round] = (now() - begin) / (double)count;
        if (worst > 1) fail("a call was refused");
    }
    qsort(taken, (size_t)rounds, sizeof *taken, rising);
    printf("%.17g", taken[rounds / 2]);
    for (size_t i = 0; i < outs; i++) printf(" %.17g", values[i]);
    putchar('\n');
    fflush(stdout);
    _Exit(0); /* an embedded Python does not always end well */
}
