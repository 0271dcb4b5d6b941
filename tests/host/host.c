/* The smallest importer that there is: loads one FMI 2.0 co-simulation binary, flies it, and prints what it puts out.
 *
 *     host LIBRARY GUID RESOURCE_URI STEP COUNT EVERY [REFERENCE=VALUE | REFERENCE]...
 *
 * REFERENCE=VALUE sets a real before the flight; a REFERENCE alone is printed, in a row after the time, first at the start
 * and then after EVERY steps of STEP seconds, COUNT of them in all. Exit code: 0, or 1 with a line on standard error.
 *
 * It runs where no Python does: under Wine, under QEMU, and under Valgrind without an interpreter's noise.
 *
 * The environment variables HOST_ROUND_UP, HOST_TRAP and HOST_STACK make it unusual: it then rounds upward, traps
 * floating-point exceptions, or does all of this in a thread with a stack of so many bytes. */

#define _GNU_SOURCE
#include <fenv.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *open_library(const char *path) { return (void *)LoadLibraryA(path); }
static void *find(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
static void close_library(void *library) { FreeLibrary((HMODULE)library); }
static const char *problem(void) {
    static char text[32];
    snprintf(text, sizeof text, "error %lu", GetLastError());
    return text;
}
#else
#include <dlfcn.h>
#include <pthread.h>
static void *open_library(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *find(void *library, const char *name) { return dlsym(library, name); }
static void close_library(void *library) { dlclose(library); }
static const char *problem(void) { return dlerror(); }
#endif

/* The types of fmi2TypesPlatform.h and fmi2FunctionTypes.h that are used here. */
typedef void *Component;
typedef unsigned int Reference;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;
typedef Component (*Instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
typedef int (*Setup)(Component, int, double, double, int, double);
typedef int (*Plain)(Component);
typedef void (*FreeInstance)(Component);
typedef int (*SetReal)(Component, const Reference *, size_t, const double *);
typedef int (*GetReal)(Component, const Reference *, size_t, double *);
typedef int (*DoStep)(Component, double, double, int);

enum { COSIMULATION = 1, MOST = 64 };

static void refuse(const char *what, const char *why) {
    fprintf(stderr, "host: %s: %s\n", what, why);
    exit(1);
}

static void require(int status, const char *call) {
    if (status > 1) { /* neither fmi2OK nor fmi2Warning */
        fprintf(stderr, "host: %s returned %d\n", call, status);
        exit(1);
    }
}

static void logger(void *environment, const char *instance, int status, const char *category, const char *text, ...) {
    va_list more;
    (void)environment;
    fprintf(stderr, "[%d] %s %s: ", status, instance, category);
    va_start(more, text);
    vfprintf(stderr, text, more);
    va_end(more);
    fputc('\n', stderr);
}

/* A data pointer does not convert to a function pointer in ISO C; its bytes do. */
static void symbol(void *library, const char *name, void *function) {
    void *address = find(library, name);
    if (address == NULL) refuse(name, "not exported");
    memcpy(function, &address, sizeof address);
}

static void row(Component c, GetReal get, double time, const Reference *wanted, size_t count) {
    double values[MOST];
    require(get(c, wanted, count, values), "fmi2GetReal");
    const int rounding = fegetround();
    fesetround(FE_TONEAREST); /* for exact digits */
    printf("%.17g", time);
    for (size_t i = 0; i < count; i++) printf(",%.17g", values[i]);
    putchar('\n');
    fesetround(rounding);
}

/* What this host traps, of the exceptions that C names. */
static int traps(void) {
#ifdef __GLIBC__
    return fegetexcept();
#else
    return 0;
#endif
}

/* Sets the floating-point environment that the environment variables ask for. */
static void set_environment(void) {
    if (getenv("HOST_ROUND_UP") != NULL && fesetround(FE_UPWARD) != 0) refuse("HOST_ROUND_UP", "not possible here");
    if (getenv("HOST_TRAP") == NULL) return;
#ifdef __GLIBC__
    if (feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW | FE_UNDERFLOW) != -1) return;
#endif
    refuse("HOST_TRAP", "not possible here");
}

static int fly(int argc, char **argv) {
    Reference wanted[MOST];
    size_t count = 0;
    Instantiate instantiate;
    Setup setup;
    Plain enter, leave, terminate;
    FreeInstance release;
    SetReal set;
    GetReal get;
    DoStep step;

    if (argc < 7) refuse("usage", "host LIBRARY GUID RESOURCE_URI STEP COUNT EVERY [REFERENCE=VALUE | REFERENCE]...");
    void *library = open_library(argv[1]);
    if (library == NULL) refuse(argv[1], problem());
    symbol(library, "fmi2Instantiate", &instantiate);
    symbol(library, "fmi2SetupExperiment", &setup);
    symbol(library, "fmi2EnterInitializationMode", &enter);
    symbol(library, "fmi2ExitInitializationMode", &leave);
    symbol(library, "fmi2Terminate", &terminate);
    symbol(library, "fmi2FreeInstance", &release);
    symbol(library, "fmi2SetReal", &set);
    symbol(library, "fmi2GetReal", &get);
    symbol(library, "fmi2DoStep", &step);

    const double size = strtod(argv[4], NULL);
    const long steps = strtol(argv[5], NULL, 10), every = strtol(argv[6], NULL, 10);
    set_environment();
    const int rounding = fegetround(), trapped = traps();
    const Callbacks callbacks = {logger, calloc, free, NULL, NULL};
    Component c = instantiate("host", COSIMULATION, argv[2], argv[3], &callbacks, 0, 0);
    if (c == NULL) refuse("fmi2Instantiate", "returned NULL");
    require(setup(c, 0, 0.0, 0.0, 0, 0.0), "fmi2SetupExperiment");
    for (int i = 7; i < argc; i++) {
        char *value = strchr(argv[i], '=');
        const Reference reference = (Reference)strtoul(argv[i], NULL, 10);
        if (value != NULL) {
            const double number = strtod(value + 1, NULL);
            require(set(c, &reference, 1, &number), "fmi2SetReal");
        } else if (count < MOST) {
            wanted[count++] = reference;
        } else {
            refuse(argv[i], "too many references");
        }
    }
    require(enter(c), "fmi2EnterInitializationMode");
    require(leave(c), "fmi2ExitInitializationMode");

    row(c, get, 0.0, wanted, count);
    for (long k = 0; k < steps; k++) {
        require(step(c, (double)k * size, size, 1), "fmi2DoStep");
        if ((k + 1) % every == 0) row(c, get, (double)(k + 1) * size, wanted, count);
    }
    require(terminate(c), "fmi2Terminate");
    release(c);
    if (fegetround() != rounding || traps() != trapped) refuse(argv[1], "changed the floating-point environment");
    close_library(library);
    return fflush(stdout) == 0 ? 0 : 1;
}

#ifdef _WIN32
int main(int argc, char **argv) { return fly(argc, argv); }
#else
struct arguments {
    int argc, result;
    char **argv;
};

static void *fly_in_thread(void *given) {
    struct arguments *arguments = given;
    arguments->result = fly(arguments->argc, arguments->argv);
    return NULL;
}

int main(int argc, char **argv) {
    const char *stack = getenv("HOST_STACK");
    struct arguments arguments = {argc, 1, argv};
    pthread_attr_t attributes;
    pthread_t thread;
    if (stack == NULL) return fly(argc, argv);
    if (pthread_attr_init(&attributes) != 0 || pthread_attr_setstacksize(&attributes, strtoul(stack, NULL, 10)) != 0
        || pthread_create(&thread, &attributes, fly_in_thread, &arguments) != 0 || pthread_join(thread, NULL) != 0)
        refuse("HOST_STACK", "no such thread");
    return arguments.result;
}
#endif
