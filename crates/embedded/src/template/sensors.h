/* What is known of a sensor; times in ticks. */
typedef struct {
    @prefix@_real last;
    @prefix@_real believed; /* the last value, or what is expected without it */
    @prefix@_real mean;
    @prefix@_real moved; /* by so much it should have, since its value changed or while it agrees */
    @prefix@_real anchor; /* what the commands gave when its value changed */
    uint32_t same, lost_for, plausible_for, wrong_for;
} @prefix@_watched;

/* The sensors, and the way to the safe commands. */
typedef struct {
@watched@
    @prefix@_real from[@m@];
    uint32_t failed_for;
    int changed, judged;
} @prefix@_sensors;
