/* Runs COUNT random ticks and prints the hash of what came out: `hash COUNT`. */

#include "ticks.h"
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    static Ticks t;
    int was_reset;
    if (argc != 2) return 1;
    begin(&t);
    for (long left = strtol(argv[1], NULL, 10); left > 0; left--) run(&t, &was_reset);
    printf("%016llx\n", (unsigned long long)t.hash);
    return 0;
}
