/* Replays ticks: reads rows of doubles (operation, inputs, applied commands) and writes for each the return code, the
 * outputs in their order, and the status. Operations: 0 step, 1 reset, 2 follow and step, 3 feed_back and step. The structs
 * consist of numbers of one type, so that they are filled and read as arrays. */

#include "example_a_b_c_f.h"
#include <stdio.h>
#include <string.h>

enum {
    INPUTS = sizeof(example_a_b_c_f_inputs) / sizeof(example_a_b_c_f_real),
    COMMANDS = sizeof(example_a_b_c_f_commands) / sizeof(example_a_b_c_f_real),
    ROW = 1 + INPUTS + COMMANDS,
    OUTPUTS = (sizeof(example_a_b_c_f_outputs) - sizeof(unsigned)) / sizeof(example_a_b_c_f_real)
};

int main(void)
{
    double row[ROW];
    example_a_b_c_f_state state;
    example_a_b_c_f_outputs out;
    memset(&out, 0, sizeof out);
    double first[OUTPUTS + 2];
    if (example_a_b_c_f_init(&state, &out) != EXAMPLE_A_B_C_F_OK) return 1;
    for (int is_first = 1; is_first || fread(row, sizeof *row, ROW, stdin) == ROW; is_first = 0) {
        int code = EXAMPLE_A_B_C_F_OK;
        if (!is_first) {
            example_a_b_c_f_inputs in;
            example_a_b_c_f_commands applied;
            example_a_b_c_f_real numbers[INPUTS + COMMANDS];
            for (int i = 0; i < INPUTS + COMMANDS; i++) numbers[i] = (example_a_b_c_f_real)row[1 + i];
            memcpy(&in, numbers, sizeof in);
            memcpy(&applied, numbers + INPUTS, sizeof applied);
            const int what = (int)row[0];
            const example_a_b_c_f_state before = state;
            if (what == 2) code = example_a_b_c_f_follow(&state, &in, &applied);
            if (what == 3) code = example_a_b_c_f_feed_back(&state, &applied);
            if (code == EXAMPLE_A_B_C_F_OK)
                code = what == 1 ? example_a_b_c_f_reset(&state, &in, &out) : example_a_b_c_f_step(&state, &in, &out);
            if (code != EXAMPLE_A_B_C_F_OK) state = before; /* also undoes follow or feed_back before a refused step */
        }
        example_a_b_c_f_real numbers[OUTPUTS];
        memcpy(numbers, &out, sizeof numbers);
        first[0] = code;
        for (int i = 0; i < OUTPUTS; i++) first[1 + i] = (double)numbers[i];
        first[OUTPUTS + 1] = out.status;
        fwrite(first, sizeof *first, OUTPUTS + 2, stdout);
    }
    return 0;
}
