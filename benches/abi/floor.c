/* The law of the controller as one would write it by hand in C, for one design: the matrices are constants in law.h, which
 * `benches/abi_peers.py` writes. It is called like an FMU, and checks nothing. */

#include "law.h"
#include <stdlib.h>
#include <string.h>

/* in: pitch, speed, pitch rate, and the references of pitch and speed. */
typedef struct {
    double in[5], filtered, x[N], next[N], command[M];
} Law;

static double interpolate(const double *grid, const double *column, double at, int hold) {
    int low = 0, high = ROWS - 1;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (grid[middle] <= at) low = middle; else high = middle;
    }
    double f = (at - grid[low]) / (grid[low + 1] - grid[low]);
    if (hold) f = f < 0.0 ? 0.0 : f > 1.0 ? 1.0 : f;
    return (1.0 - f) * column[low] + f * column[low + 1];
}

/* Gaussian elimination with partial pivoting. */
static void solve(double a[R][R], double *b) {
    for (int k = 0; k < R; k++) {
        int p = k;
        for (int i = k + 1; i < R; i++)
            if ((a[i][k] < 0 ? -a[i][k] : a[i][k]) > (a[p][k] < 0 ? -a[p][k] : a[p][k])) p = i;
        if (p != k) {
            for (int j = k; j < R; j++) { const double t = a[k][j]; a[k][j] = a[p][j]; a[p][j] = t; }
            const double t = b[k]; b[k] = b[p]; b[p] = t;
        }
        for (int i = k + 1; i < R; i++) {
            const double f = a[i][k] / a[k][k];
            for (int j = k + 1; j < R; j++) a[i][j] -= f * a[k][j];
            b[i] -= f * b[k];
        }
    }
    for (int k = R - 1; k >= 0; k--) {
        for (int j = k + 1; j < R; j++) b[k] -= a[k][j] * b[j];
        b[k] /= a[k][k];
    }
}

static double clamp(double v, double low, double high) { return v < low ? low : v > high ? high : v; }

static void tick(Law *c) {
    const double level[3] = {interpolate(FORWARD, PITCH, c->filtered, 1), c->filtered, 0.0};
    const double y[P] = Y(c->in, level);
    const double rho = clamp((interpolate(FORWARD, SPEED, c->in[1], 0) - CENTRE) / HALF, -1.0, 1.0);
    double w[R], loop[R][R];
    for (int i = 0; i < R; i++) {
        w[i] = 0.0;
        for (int j = 0; j < P; j++) w[i] += Dty[i][j] * y[j];
        for (int j = 0; j < N; j++) w[i] += Ct[i][j] * c->x[j];
        for (int j = 0; j < R; j++) loop[i][j] = (i == j) - Dtt[i][j] * rho;
    }
    solve(loop, w);
    for (int i = 0; i < R; i++) w[i] *= rho;
    for (int i = 0; i < M; i++) {
        double u = 0.0;
        for (int j = 0; j < P; j++) u += Duy[i][j] * y[j];
        for (int j = 0; j < N; j++) u += Cu[i][j] * c->x[j];
        for (int j = 0; j < R; j++) u += Dut[i][j] * w[j];
        c->command[i] = clamp(interpolate(FORWARD, TRIM[i], c->filtered, 1) + ACTUATOR[i][0] * u, ACTUATOR[i][1], ACTUATOR[i][2]);
    }
    for (int i = 0; i < N; i++) {
        double x = 0.0;
        for (int j = 0; j < P; j++) x += By[i][j] * y[j];
        for (int j = 0; j < N; j++) x += A[i][j] * c->x[j];
        for (int j = 0; j < R; j++) x += Bt[i][j] * w[j];
        c->next[i] = x;
    }
    memcpy(c->x, c->next, sizeof c->x);
    c->filtered += FILTER * (c->in[4] - c->filtered);
}

void *fmi2Instantiate(void) { return calloc(1, sizeof(Law)); }
int fmi2SetupExperiment(void) { return 0; }
int fmi2EnterInitializationMode(void) { return 0; }

int fmi2ExitInitializationMode(Law *c) {
    c->filtered = c->in[4];
    return 0;
}

int fmi2SetReal(Law *c, const unsigned *vr, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++) c->in[vr[i]] = v[i];
    return 0;
}

int fmi2GetReal(Law *c, const unsigned *vr, size_t n, double *v) {
    for (size_t i = 0; i < n; i++) v[i] = c->command[vr[i] - 5];
    return 0;
}

int fmi2DoStep(Law *c, double at, double size, int flag) {
    (void)at, (void)size, (void)flag;
    tick(c);
    return 0;
}
