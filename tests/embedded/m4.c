/* COUNT random ticks on a Cortex-M4 without operating system or C library. Says by semihosting the hash of what came out, the
 * bytes of the state, and the bytes of stack that the deepest call of the autopilot took. */

#include "ticks.h"

extern unsigned char end_of_data[], top_of_stack[];
int main(void);

/* Asks the debugger, here QEMU (Arm, Semihosting for AArch32 and AArch64, section 2). */
static int ask(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

enum { WRITE = 0x04, EXIT = 0x18, STOPPED = 0x20026 };

static void say(uint64_t number)
{
    char text[] = "0000000000000000 ";
    for (int i = 15; i >= 0; i--, number >>= 4) text[i] = "0123456789abcdef"[number & 0xf];
    ask(WRITE, text);
}

static void start(void)
{
    *(volatile uint32_t *)0xe000ed88u |= 0xfu << 20; /* the coprocessors of floating point may be used */
    __asm__ volatile("dsb\n isb");
    main();
    ask(EXIT, (const void *)STOPPED);
    for (;;) {}
}

static void fault(void)
{
    ask(WRITE, "fault");
    ask(EXIT, (const void *)STOPPED);
}

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    top_of_stack, (const void *)start, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault, (const void *)fault,
};

/* What the compiler calls for copies of structs. */
void *memcpy(void *restrict to, const void *restrict from, size_t size)
{
    for (size_t i = 0; i < size; i++) ((volatile unsigned char *)to)[i] = ((const unsigned char *)from)[i];
    return to;
}

void *memset(void *to, int byte, size_t size)
{
    for (size_t i = 0; i < size; i++) ((volatile unsigned char *)to)[i] = (unsigned char)byte;
    return to;
}

enum { PAINT = 0xa5, MARGIN = 64 };

/* The address of the frame that calls. */
static unsigned char *here(void) { return __builtin_frame_address(0); }

int main(void)
{
    static Ticks t;
    static OF(state) state;
    static OF(outputs) out;
    int was_reset;
    begin(&t);
    for (long left = COUNT; left > 0; left--) run(&t, &was_reset);

    /* The inputs are those of the last tick; a saturated one takes every branch that needs stack. */
    unsigned char *const top = here() - MARGIN;
    for (volatile unsigned char *p = end_of_data; p < top; p++) *p = PAINT;
    OF(init)(&state, &out);
    OF(step)(&state, &t.in, &out);
    const unsigned char *lowest = end_of_data;
    while (lowest < top && *lowest == PAINT) lowest++;
    say(t.hash);
    say(sizeof(OF(state)));
    say((uint64_t)(top + MARGIN - lowest));
    return 0;
}
