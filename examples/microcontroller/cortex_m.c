/* cortex_m.c - vectors and semihosting of Cortex-M0 to M7. SPDX-License-Identifier: MIT */
#include "board.h"
#include "runtime.h"

#define FAULT_STATUS 99

extern uint32_t stack_top[]; /* link.ld */

uintptr_t semihosting(uintptr_t operation, uintptr_t argument)
{
    register uintptr_t r0 __asm__("r0") = operation;
    register uintptr_t r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

/* A leaf without a frame: the caller's stack pointer. */
uintptr_t board_stack_pointer(void)
{
    uintptr_t sp;
    __asm__ volatile("mov %0, sp" : "=r"(sp));
    return sp;
}

static void fault(void)
{
    board_print("fault\n");
    semihosting_exit(FAULT_STATUS);
}

/* The first words of flash: stack pointer, reset, and what may go wrong. */
typedef struct vectors {
    uint32_t *stack;
    void (*handler[15])(void);
} vectors;

__attribute__((section(".vectors"), used)) static const vectors table = {
    stack_top, { start_main, fault, fault, fault, fault, fault }
};
