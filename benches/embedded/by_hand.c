/* The law of the controller as one would write it by hand in C, for one design, and the time of a tick beside that of the source
 * that `squid export` writes. The matrices are constants in law.h, which `benches/embedded.py` writes: those of one tick, in
 * coordinates in which the loop through rho is quasi-triangular. The law checks nothing and has no status.
 *
 *     by_hand COUNT ROUNDS: prints the median ns a tick by hand, of the source, the median of their ratios, and the largest
 *     difference of a command. */

#define _POSIX_C_SOURCE 200809L
#include "law.h"
#include "squid.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct {
    double filtered, x[N], command[M];
} Law;

static double clamp(double v, double low, double high) { return v < low ? low : v > high ? high : v; }

static int row_at(double at)
{
    int low = 0, high = ROWS - 1;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (FORWARD[middle] <= at) low = middle; else high = middle;
    }
    return low;
}

static double part_at(int row, double at) { return (at - FORWARD[row]) / (FORWARD[row + 1] - FORWARD[row]); }

static double between(double low, double high, double part) { return low + part * (high - low); }

/* (I - rho T) z = z, from the last row to the first; blocks of two rows where T has an entry below its diagonal. */
static void solve(double rho, double *z)
{
    for (int i = R - 1; i >= 0; i--) {
        for (int j = i + 1; j < R; j++) z[i] += rho * T[i][j] * z[j];
        if (i > 0 && T[i][i - 1] != 0.0) {
            const int k = i - 1;
            for (int j = i + 1; j < R; j++) z[k] += rho * T[k][j] * z[j];
            const double a = 1.0 - rho * T[k][k], b = -rho * T[k][i], c = -rho * T[i][k], d = 1.0 - rho * T[i][i];
            const double first = (d * z[k] - b * z[i]) / (a * d - b * c);
            z[i] = (a * z[i] - c * z[k]) / (a * d - b * c);
            z[k] = first;
            i--;
        } else {
            z[i] /= 1.0 - rho * T[i][i];
        }
    }
}

static void tick(Law *c, const squid_inputs *in)
{
    const int row = row_at(c->filtered), here = row_at(in->speed);
    const double part = clamp(part_at(row, c->filtered), 0.0, 1.0);
    const double pitch = between(PITCH[row], PITCH[row + 1], part);
    const double along = between(SPEED[here], SPEED[here + 1], part_at(here, in->speed));
    const double rho = clamp((along - CENTRE) / HALF, -1.0, 1.0);
    double v[N + P + R], z[R], next[N], excess[M];
    for (int i = 0; i < N; i++) v[i] = c->x[i];
    Y(v + N, in, pitch, c->filtered);
    for (int i = 0; i < R; i++) {
        z[i] = 0.0;
        for (int j = 0; j < N + P; j++) z[i] += INTO[i][j] * v[j];
    }
    solve(rho, z);
    for (int i = 0; i < R; i++) v[N + P + i] = rho * z[i];
    int limited = 0;
    for (int i = 0; i < M; i++) {
        double u = 0.0;
        for (int j = 0; j < N + P + R; j++) u += OUT[i][j] * v[j];
        const double value = between(TRIM[row][i], TRIM[row + 1][i], part) + ACTUATOR[i][0] * u;
        c->command[i] = clamp(value, ACTUATOR[i][1], ACTUATOR[i][2]);
        excess[i] = (value - c->command[i]) / ACTUATOR[i][0];
        limited |= value != c->command[i];
    }
    for (int i = 0; i < N; i++) {
        next[i] = 0.0;
        for (int j = 0; j < N + P + R; j++) next[i] += UP[i][j] * v[j];
    }
    for (int i = 0; i < N; i++) c->x[i] = next[i];
    if (limited)
        for (int i = 0; i < N; i++)
            for (int j = 0; j < M; j++) c->x[i] += E[i][j] * excess[j];
    c->filtered += FILTER * (in->speed_reference - c->filtered);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t); /* not the time that others have the processor */
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static int rising(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* A bounded, ever changing course of the inputs, with references within their limits and measurements that no vehicle is
 * too slow for; cheap beside a tick. */
static squid_inputs inputs(long k)
{
    const double a = (double)(k % 101) / 101.0, b = 1.0 - fabs((double)(k % 74) / 37.0 - 1.0);
    const double c = fabs((double)(k % 100) / 50.0 - 1.0);
    const squid_inputs in = {0.05 * (a - 0.5), 1.0 + 0.5 * b, 0.05 * (a - b), 0.05 * (b - 0.5), 1.0 + 0.5 * c};
    return in;
}

enum { MOST = 1001 };

int main(int argc, char **argv)
{
    static double hand[MOST], source[MOST], ratio[MOST];
    const long count = argc == 3 ? strtol(argv[1], NULL, 10) : 0, rounds = argc == 3 ? strtol(argv[2], NULL, 10) : 0;
    if (count < 1 || rounds < 1 || rounds > MOST) return 1;
    double largest = 0.0;
    for (long round = 0; round < rounds; round++) {
        squid_inputs in = inputs(0);
        squid_state state;
        squid_outputs out;
        Law law = {.filtered = in.speed_reference};
        if (squid_init(&state, &out) != SQUID_OK || squid_reset(&state, &in, &out) != SQUID_OK) return 1;
        int code = 0;
        const double begin = now();
        for (long k = 0; k < count; k++) {
            in = inputs(k);
            tick(&law, &in);
        }
        const double middle = now();
        for (long k = 0; k < count; k++) {
            in = inputs(k);
            code |= squid_step(&state, &in, &out);
        }
        const double end = now();
        if (code != SQUID_OK) return 1;
        hand[round] = (middle - begin) / (double)count;
        source[round] = (end - middle) / (double)count;
        ratio[round] = source[round] / hand[round];
        const double commands[M] = COMMANDS(out);
        for (int i = 0; i < M; i++) largest = fmax(largest, fabs(commands[i] - law.command[i]));
    }
    qsort(hand, (size_t)rounds, sizeof *hand, rising);
    qsort(source, (size_t)rounds, sizeof *source, rising);
    qsort(ratio, (size_t)rounds, sizeof *ratio, rising);
    printf("%.17g %.17g %.17g %.17g\n", hand[rounds / 2], source[rounds / 2], ratio[rounds / 2], largest);
    return 0;
}
