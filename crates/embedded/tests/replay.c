/* Replays ticks: reads rows of doubles, first 1 for a reset or 0 for a step, then the inputs, and writes for each the code
 * that the function returned, the outputs in their order, and the status. The inputs and the outputs are structs of
 * numbers of one type, so that they are filled and read as arrays. */

#include "example.h"
#include <stdio.h>
#include <string.h>

enum {
    INPUTS = sizeof(example_inputs) / sizeof(example_real),
    OUTPUTS = (sizeof(example_outputs) - sizeof(unsigned)) / sizeof(example_real)
};

int main(void)
{
    double row[1 + INPUTS];
    example_state state;
    example_outputs out;
    memset(&out, 0, sizeof out);
    double first[OUTPUTS + 2];
    if (example_init(&state, &out) != EXAMPLE_OK) return 1;
    for (int is_first = 1; is_first || fread(row, sizeof *row, 1 + INPUTS, stdin) == 1 + INPUTS; is_first = 0) {
        int code = EXAMPLE_OK;
        if (!is_first) {
            example_inputs in;
            example_real numbers[INPUTS], *to = numbers;
            for (int i = 0; i < INPUTS; i++) *to++ = (example_real)row[1 + i];
            memcpy(&in, numbers, sizeof in);
            code = row[0] > 0.5 ? example_reset(&state, &in, &out) : example_step(&state, &in, &out);
        }
        example_real numbers[OUTPUTS];
        memcpy(numbers, &out, sizeof numbers);
        first[0] = code;
        for (int i = 0; i < OUTPUTS; i++) first[1 + i] = (double)numbers[i];
        first[OUTPUTS + 1] = out.status;
        fwrite(first, sizeof *first, OUTPUTS + 2, stdout);
    }
    return 0;
}
