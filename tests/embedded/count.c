/* count.c - plugin of qemu that counts the instructions of a guest's function. SPDX-License-Identifier: MIT
 *
 *     qemu-system-arm -plugin ./libcount.so,begin=0x1234,end=0x5678 -d plugin ...
 *
 * Counts from each time that the guest reaches the address `begin` until it reaches `end`. At the end prints how
 * many such stretches there were, the instructions of the first, of all, and of the longest but the first. Exact: the
 * same in every run. The prototypes are those of qemu's plugin interface, version 1; Debian has no header for it. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
enum { NO_REGISTERS = 0, ADD_U64 = 0 };
typedef void (*translate_function)(qemu_plugin_id_t, struct qemu_plugin_tb *);
typedef void (*exec_function)(unsigned cpu, void *user);
typedef void (*exit_function)(qemu_plugin_id_t, void *user);

extern void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t, translate_function);
extern void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn *, exec_function, int flags, void *user);
extern void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn *, int op, void *to, uint64_t add);
extern void qemu_plugin_register_atexit_cb(qemu_plugin_id_t, exit_function, void *user);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *);
extern struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *, size_t);
extern uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *);
extern void qemu_plugin_outs(const char *);
int qemu_plugin_install(qemu_plugin_id_t id, const void *info, int argc, char **argv);

int qemu_plugin_version = 1;

static uint64_t count;        /* instructions so far */
static uint64_t begin, end;   /* addresses */
static uint64_t begun;        /* count at `begin` */
static uint64_t stretches, first, total, longest;

static void on_begin(unsigned cpu, void *user)
{
    (void)cpu;
    (void)user;
    begun = count;
}

static void on_end(unsigned cpu, void *user)
{
    uint64_t n = count - begun;
    (void)cpu;
    (void)user;
    total += n;
    if (!stretches++) first = n;
    else if (n > longest) longest = n;
}

static void translate(qemu_plugin_id_t id, struct qemu_plugin_tb *block)
{
    size_t i, n = qemu_plugin_tb_n_insns(block);
    (void)id;
    for (i = 0; i < n; i++) {
        struct qemu_plugin_insn *instruction = qemu_plugin_tb_get_insn(block, i);
        uint64_t address = qemu_plugin_insn_vaddr(instruction);
        if (address == begin) qemu_plugin_register_vcpu_insn_exec_cb(instruction, on_begin, NO_REGISTERS, NULL);
        if (address == end) qemu_plugin_register_vcpu_insn_exec_cb(instruction, on_end, NO_REGISTERS, NULL);
        qemu_plugin_register_vcpu_insn_exec_inline(instruction, ADD_U64, &count, 1);
    }
}

static void print(qemu_plugin_id_t id, void *user)
{
    char text[160];
    (void)id;
    (void)user;
    snprintf(text, sizeof text, "steps %llu\nfirst %llu\ntotal %llu\nlongest %llu\n", (unsigned long long)stretches,
             (unsigned long long)first, (unsigned long long)total, (unsigned long long)longest);
    qemu_plugin_outs(text);
}

int qemu_plugin_install(qemu_plugin_id_t id, const void *info, int argc, char **argv)
{
    int i;
    (void)info;
    for (i = 0; i < argc; i++) {
        if (!strncmp(argv[i], "begin=", 6)) begin = strtoull(argv[i] + 6, NULL, 16);
        if (!strncmp(argv[i], "end=", 4)) end = strtoull(argv[i] + 4, NULL, 16);
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, translate);
    qemu_plugin_register_atexit_cb(id, print, NULL);
    return 0;
}
