/* The way of a reference to what is asked. */
typedef struct {
    @prefix@_real start, rate; /* where it began, moved on by the rate at which it did */
    @prefix@_real share, lag; /* 1: the share of the start in the reference; exp(-t/1 s) */
} @prefix@_transition;
