/* riscv.c - entry and semihosting of RV32 in machine mode. SPDX-License-Identifier: MIT */
#include "board.h"
#include "runtime.h"

#define FAULT_STATUS 99

void fault(void);

__asm__(".section .vectors, \"ax\"\n"
        ".globl _start\n"
        "_start:\n"
        "    la sp, stack_top\n"
        "    la t0, fault\n"
        "    .option push\n"
        "    .option arch, +zicsr\n"
        "    csrw mtvec, t0\n"
        "    .option pop\n"
        "    j start_main\n"
        ".text\n");

/* Three uncompressed instructions in one page are the call. */
__asm__(".balign 16\n"
        ".globl semihosting\n"
        "semihosting:\n"
        "    .option push\n"
        "    .option norvc\n"
        "    slli x0, x0, 0x1f\n"
        "    ebreak\n"
        "    srai x0, x0, 7\n"
        "    .option pop\n"
        "    ret\n");

/* A leaf without a frame: the caller's stack pointer. */
uintptr_t board_stack_pointer(void)
{
    uintptr_t sp;
    __asm__ volatile("mv %0, sp" : "=r"(sp));
    return sp;
}

__attribute__((aligned(4))) void fault(void)
{
    board_print("fault\n");
    semihosting_exit(FAULT_STATUS);
}
