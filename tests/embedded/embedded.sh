#!/bin/sh
# The decoder on devices without an operating system: embedded.sh check | figures
#
# check     builds examples/microcontroller for each device, runs it in qemu, compares what it decodes with the host and
#           with other compilers, measures, and holds the figures against budgets.tsv and the committed figures.tsv.
#           The last line is `N passed, N failed`.
# figures   writes figures.tsv and README's tables of it anew; and the table of the bench, if `make bench` has run.
#
# Everything measured here is exact: bytes of the files built, instructions that qemu executed. The same compilers give
# the same figures on any machine; with others (figures.tsv names them) only the budgets are checked.
set -u
cd "$(dirname "$0")/../.." || exit
here=tests/embedded
example=examples/microcontroller
out=build/embedded
cqm=build/cqm
flags="-std=c99 -Wall -Wextra -Wconversion -pedantic -Werror -Iinclude"
semihosting="-nographic -monitor none -serial none -semihosting-config enable=on,target=native"

passed=0
failed=0
check() {
    label=$1
    shift
    if "$@" >"$out/log" 2>&1; then
        passed=$((passed + 1))
        echo "ok    $label"
    else
        failed=$((failed + 1))
        echo "FAIL  $label"
        head -n 20 "$out/log"
    fi
}

# -- Streams ---------------------------------------------------------------------------------------------------------

# counts STREAM: its vertices and faces, boundary loops and edges included, as macros
counts() {
    "$cqm" info --json "$1" | awk -F '[:,]' '
        /^  "(vertices|faces|boundary_loops|boundary_edges)":/ { gsub(/[" ]/, ""); n[$1] = $2 }
        END {
            print "#define STREAM_VERTICES " n["vertices"] + n["boundary_loops"]
            print "#define STREAM_FACES " n["faces"] + n["boundary_edges"]
        }'
}

# make_stream NAME MESH OPTION...: build/embedded/NAME/stream.h
make_stream() {
    name=$1 mesh=$2
    shift 2
    mkdir -p "$out/$name"
    "$cqm" encode --quiet "$@" "$mesh" "$out/$name.cqm" && counts "$out/$name.cqm" >"$out/$name/stream.h" &&
        {
            echo "static const uint8_t stream[] = {"
            od -An -v -tu1 "$out/$name.cqm" | sed 's/\([0-9]\) /\1, /g; s/$/,/'
            echo "};"
        } >>"$out/$name/stream.h"
}

# regular: has regular levels, and is not for decoders that were built without them. disc: of ref_data, 33 vertices;
# fits the 16 KiB of a micro:bit. small: those of an AVR, which has constants there, too. grid: of ref_data, larger.
# random: 1000 vertices. torus: of ref_data, for the display.
make_streams() {
    make_stream disc ref_data/disc.off --conquest-only && make_stream grid ref_data/grid.off --conquest-only &&
        build/meshgen disc 5 3 >"$out/small.off" && make_stream small "$out/small.off" --conquest-only &&
        build/meshgen random 1000 1 >"$out/random.off" && make_stream random "$out/random.off" --conquest-only &&
        make_stream torus ref_data/torus_12x8.off --conquest-only && "$cqm" decode "$out/torus.cqm" "$out/torus.off" &&
        make_stream regular ref_data/grid.off && "$cqm" info "$out/regular.cqm" | grep -q regular
}

# -- Devices ---------------------------------------------------------------------------------------------------------

# device NAME [all]: the tools and the memory of a device, whose decoder can do without seams and regular levels, or not
device() {
    tools=arm-none-eabi-
    start=cortex_m
    case $1 in
    cortex-m3)
        cpu="-mcpu=cortex-m3 -mthumb" memory="0 0x40000 0x20000000 0xc000"
        qemu="qemu-system-arm -M lm3s6965evb"
        imports="memcpy memset" ;;
    cortex-m0)
        cpu="-mcpu=cortex-m0 -mthumb" memory="0 0x40000 0x20000000 0x4000"
        qemu="qemu-system-arm -M microbit"
        imports="memcpy memset __aeabi_u?i(div|divmod) __clzsi2 __aeabi_(lmul|llsl|llsr|lasr)"
        imports="$imports __gnu_thumb1_case_[us][qhs]i" ;;
    rv32)
        tools=riscv64-unknown-elf-
        start=riscv
        cpu="-march=rv32imc -mabi=ilp32" memory="0x80000000 0x40000 0x80100000 0xc000"
        qemu="qemu-system-riscv32 -M virt -bios none"
        imports="memcpy memset __clzsi2 __(ashl|lshr|ashr)di3" ;;
    avr)
        tools=avr-
        cpu="-mmcu=atmega1284p -Wno-conversion -Wno-main" ;;
    esac
    bare="$flags $cpu -Os -DCQ_INDEX_BITS=16 -I$example -ffreestanding -ffunction-sections -fdata-sections"
    bare="$bare -fno-tree-loop-distribute-patterns"
    build=${2:+-$2}
    work=$out/$1$build
    mkdir -p "$work"
    if [ -n "$build" ]; then
        suffix=_16 imports="$imports __aeabi_u?ldivmod"
    else
        suffix=_16_nr bare="$bare -DCQ_NO_REGULAR -DCQ_NO_WEDGES -DCQ_NO_ATTRIBUTES"
    fi
}

# shellcheck disable=SC2086 # flags are words
compile_device() {
    for file in decoder runtime $start; do
        ${tools}gcc $bare -fcallgraph-info=su -c $example/$file.c -o "$work/$file.o" || return 1
    done
}

# What a program that decodes gets of decoder.o: all that cq_decoder_init and cq_decode call.
# shellcheck disable=SC2086
link_decoder() {
    ${tools}gcc $cpu -nostdlib -r -Wl,--gc-sections,-e,cq_decode$suffix,-u,cq_decoder_init$suffix "$work/decoder.o" \
        -o "$work/linked.o"
}

# build_program STREAM [SOURCE]...: main.c, if there is no SOURCE
# shellcheck disable=SC2086
build_program() {
    stream=$1 objects=
    shift
    for source in "${@:-main}"; do
        ${tools}gcc $bare -I"$out/$stream" -c "$example/$source.c" -o "$work/$stream-$source.o" || return 1
        objects="$objects $work/$stream-$source.o"
    done
    set -- $memory
    ${tools}gcc $cpu -nostdlib -Wl,--gc-sections,--no-warn-rwx-segments -T $example/link.ld \
        -Wl,--defsym=FLASH="$1",--defsym=FLASH_BYTES="$2",--defsym=RAM="$3",--defsym=RAM_BYTES="$4" \
        "$work/$start.o" "$work/runtime.o" "$work/decoder.o" $objects -lgcc -o "$work/$stream.elf"
}

address() { ${tools}nm "$work/$1.elf" | awk -v name="$2" '$3 == name { print $1 }'; }

# run_program STREAM: what it prints, and then the plugin, is in STREAM.txt
# shellcheck disable=SC2086
run_program() {
    between="begin=$(address "$1" cq_decode$suffix),end=$(address "$1" board_step)"
    timeout 60 $qemu $semihosting -kernel "$work/$1.elf" -d plugin -plugin "$out/libcount.so,$between" \
        >"$work/$1.txt" 2>&1 || { cat "$work/$1.txt"; return 1; }
}

value() { awk -v key="$2" '$1 == key { print $2 }' "$1"; }

# same_mesh A B: both complete, with the same hash
same_mesh() {
    cat "$1" "$2"
    [ "$(value "$1" result)" = complete ] && [ "$(value "$2" result)" = complete ] &&
        [ -n "$(value "$1" hash)" ] && [ "$(value "$1" hash)" = "$(value "$2" hash)" ]
}

# The decoder takes two functions from libc, and from the compiler's library at most what the processor lacks for 32-bit
# integers, and shifts and products of 64 bits: no allocation, no floats, no 64-bit division but in
# regular levels and seams.
# shellcheck disable=SC2086
imports_are_known() {
    ${tools}nm -u "$work/linked.o" | awk '{ print $2 }' >"$work/imports"
    known=$(echo $imports | tr ' ' '|')
    ! grep -Evx "$known" "$work/imports"
}

# section_bytes PREFIX ...: of all sections whose names begin like that
section_bytes() {
    ${tools}size -A "$work/linked.o" | awk -v names="$*" '
        BEGIN { count = split(names, prefix, " ") }
        { for (k = 1; k <= count; k++) if (index($1, prefix[k]) == 1) bytes += $2 }
        END { print bytes + 0 }'
}

# ram STREAM: static data and the stack that was used
ram() { echo $(($(${tools}size "$work/$1.elf" | awk 'NR == 2 { print $2 + $3 }') + $(value "$work/$1.txt" stack))); }

figure() { printf '%s\t%s\n' "$1" "$2" >>"$out/figures.tsv"; }

# measure_code DEVICE
measure_code() {
    figure "code$build.$1" "$(section_bytes .text)"
    figure "tables$build.$1" "$(section_bytes .rodata .srodata)"
}

measure_decoder() {
    measure_code "$1"
    figure "writable.$1" "$(section_bytes .data .sdata .bss .sbss)"
    "$here/stack.py" "cq_decode$suffix" "$work/decoder.ci" "$work/runtime.ci" >"$work/stack" || return 1
    figure "stack.$1" "$(sed 's/ .*//' "$work/stack")"
    cat "$work/stack"
}

# measure_run DEVICE STREAM
measure_run() {
    result=$work/$2.txt
    grep -q '^longest ' "$result" || return 1
    figure "painted.$1" "$(value "$result" stack)"
    figure "sizeof.$1" "$(value "$result" decoder)"
    figure "ram.$1" "$(ram "$2")"
    figure "split.$1" $(($(value "$result" total) / $(value "$result" splits)))
    figure "longest.$1" "$(value "$result" longest)"
}

# test_device NAME STREAM...: figures are of the last stream
test_device() {
    name=$1
    shift
    device "$name"
    check "$name: compiles" compile_device
    check "$name: links" link_decoder
    check "$name: imports" imports_are_known
    check "$name: stack bound" measure_decoder "$name"
    for stream in "$@"; do
        check "$name: program for $stream" build_program "$stream"
        check "$name: decodes $stream" run_program "$stream"
        check "$name: same mesh as the host, $stream" same_mesh "$work/$stream.txt" "$out/host/$stream.txt"
    done
    check "$name: figures" measure_run "$name" "$stream"
}

# test_code NAME [all]: a device that is not run with this decoder
# shellcheck disable=SC2086
test_code() {
    device "$@"
    check "$*: compiles" ${tools}gcc $bare -c $example/decoder.c -o "$work/decoder.o"
    check "$*: links" link_decoder
    check "$*: code" measure_code "$1"
}

# With all that streams may have: regular levels, seams.
test_all() {
    test_code avr
    for name in avr cortex-m0 rv32; do test_code $name all; done
    device cortex-m3 all
    check "cortex-m3, all: compiles" compile_device
    check "cortex-m3, all: links" link_decoder
    check "cortex-m3, all: imports" imports_are_known
    check "cortex-m3, all: code" measure_code cortex-m3
    check "cortex-m3, all: program" build_program regular
    check "cortex-m3, all: decodes regular" run_program regular
    check "cortex-m3, all: same mesh as the host, regular" same_mesh "$work/regular.txt" "$out/host/regular.txt"
}

# -- A display -------------------------------------------------------------------------------------------------------

# Every frame is the host's, there are several, and the last one is as it should be.
same_frames() {
    grep '^frame' "$work/torus.txt" >"$work/frames" && diff "$work/frames" "$out/host/frames" &&
        [ "$(grep -c '^frame_hash' "$work/frames")" -gt 9 ] &&
        $here/wireframe.py "$work/torus.txt" "$out/torus.off"
}

test_display() {
    device cortex-m3
    check "display: compiles for the host" cc $flags -O2 -DCQ_INDEX_BITS=16 -I"$out/torus" $example/display.c \
        $example/wireframe.c $example/decoder.c $example/host.c -o "$out/host/display"
    check "display: runs on the host" sh -c "$out/host/display | grep '^frame' >$out/host/frames"
    check "display: program for cortex-m3" build_program torus display wireframe
    check "display: runs on cortex-m3" run_program torus
    check "display: frames" same_frames
}

# -- README's lines for a microcontroller --------------------------------------------------------------------------

# shellcheck disable=SC2086
build_door() {
    tests/doors/door.sh embedded >"$out/embedded.inc" || return 1
    set -- $memory
    ${tools}gcc $bare -I"$out/random" -I"$out" tests/doors/embedded.c "$work/$start.o" "$work/runtime.o" \
        -nostdlib -Wl,--gc-sections,--no-warn-rwx-segments -T $example/link.ld -Wl,--defsym=FLASH="$1",--defsym=RAM="$3" \
        -Wl,--defsym=FLASH_BYTES="$2",--defsym=RAM_BYTES="$4" -lgcc -o "$work/door.elf"
}

# shellcheck disable=SC2086
run_door() { timeout 60 $qemu $semihosting -kernel "$work/door.elf" >"$work/door.txt" 2>&1; }

test_door() {
    device cortex-m3 all
    check "README: compiles" build_door
    check "README: runs" run_door
    check "README: same mesh as the host" same_mesh "$work/door.txt" "$out/host/random.txt"
}

# -- Other compilers -------------------------------------------------------------------------------------------------

# test_process NAME STREAMS RUN COMPILE...: programs for an operating system, one for each stream
test_process() {
    name=$1 streams=$2 run=$3
    shift 3
    mkdir -p "$out/$name"
    check "$name: compiles" "$@" -std=c99 -Iinclude -c $example/decoder.c -o "$out/$name/decoder.o"
    for stream in $streams; do
        check "$name: program for $stream" "$@" -std=c99 -Iinclude -I"$out/$stream" $example/main.c $example/host.c \
            "$out/$name/decoder.o" -o "$out/$name/$stream"
        check "$name: decodes $stream" sh -c "$run $out/$name/$stream >$out/$name/$stream.txt"
        check "$name: same mesh, $stream" same_mesh "$out/$name/$stream.txt" "$out/host/$stream.txt"
    done
}

# AVR, where int has 16 bits: without -Wconversion, which warns of integer promotion there.
# shellcheck disable=SC2086
compile_avr() { # name source...
    name=$1
    shift
    mkdir -p "$out/avr" &&
        avr-gcc $flags -Wno-conversion -Wno-main -mmcu=atmega1284p -Os -DCQ_INDEX_BITS=16 -DCQ_NO_REGULAR -DCQ_NO_WEDGES -DCQ_NO_ATTRIBUTES \
            -ffunction-sections -fdata-sections -Wl,--gc-sections -I"$out/$name" -I$example "$@" $example/avr.c -o "$out/avr/$name.elf"
}

# The simulator colours what comes out of the serial port, and shows a dot for the end of a line.
run_avr() {
    timeout 60 simavr -m atmega1284p "$out/avr/$1.elf" >"$out/avr/$1.log" 2>&1
    sed 's/\x1b\[[0-9]*m//g; s/\.$//' "$out/avr/$1.log" >"$out/avr/$1.txt"
}

test_avr() {
    check "avr: compiles" compile_avr "$1" $example/main.c $example/decoder.c
    check "avr: decodes $1" run_avr "$1"
    check "avr: same mesh as the host, $1" same_mesh "$out/avr/$1.txt" "$out/host/$1.txt"
}

test_avr_sizes() {
    check "avr: compiles sizes" compile_avr sizes tests/embedded/sizes.c
    check "avr: runs sizes" run_avr sizes
    check "avr: sizes that do not fit are refused" grep -q '^all refused$' "$out/avr/sizes.txt"
}

test_compilers() {
    others="grid random regular"
    test_process tcc "$others" "" tcc -DCQ_INDEX_BITS=16
    test_process big-endian "$others" qemu-s390x s390x-linux-gnu-gcc -O2 -static
    test_process big-endian-16 "$others" qemu-s390x s390x-linux-gnu-gcc -O2 -static -DCQ_INDEX_BITS=16
    test_process host-16 "$others" "" cc -O2 -DCQ_INDEX_BITS=16
    test_avr small
    test_avr_sizes
}

# -- Figures ---------------------------------------------------------------------------------------------------------

# Of the published formula.
measure_memory() {
    for bits in 32 16; do
        cc -std=c99 -Iinclude -DCQ_INDEX_BITS=$bits tests/measure/memory/memory.c -o "$out/memory-$bits" || return 1
        "$out/memory-$bits" >"$out/memory-$bits.txt" || return 1
        figure "sizeof.$bits-bit" "$(sed 's/.*cq_decoder \([0-9]*\).*/\1/' "$out/memory-$bits.txt")"
        figure "connectivity.$bits-bit" "$(sed 's/.*without \([0-9.]*\).*/\1/' "$out/memory-$bits.txt")"
        figure "decoder.$bits-bit" "$(sed 's/.*with positions \([0-9.]*\).*/\1/' "$out/memory-$bits.txt")"
        figure "encoder.$bits-bit" "$(sed 's/.*encoder \([0-9.]*\).*/\1/' "$out/memory-$bits.txt")"
        figure "most.$bits-bit" "$(sed 's/.*at most \([0-9]*\)$/\1/' "$out/memory-$bits.txt")"
    done
}

compilers() {
    printf '# gcc of cortex-m %s, of rv32 %s\n' \
        "$(arm-none-eabi-gcc -dumpfullversion)" "$(riscv64-unknown-elf-gcc -dumpfullversion)"
}

within() {
    echo "$1: $2 of at most $3"
    awk -v figure="$2" -v most="$3" 'BEGIN { exit !(figure != "" && figure + 0 <= most + 0) }'
}

check_budgets() {
    while read -r name most; do
        case $name in \#*) continue ;; esac
        check "budget: $name" within "$name" "$(value "$out/figures.tsv" "$name")" "$most"
    done <$here/budgets.tsv
}

unchanged() {
    diff "$here/figures.tsv" "$out/figures.tsv" && return
    echo "larger is a regression; if it is meant: make figures, and commit what that writes"
    return 1
}

# README shows what figures.tsv has.
readme_is_current() {
    cp README.md "$out/README.md" &&
        $here/readme.py "$out/README.md" $here/figures.tsv $here/budgets.tsv && diff README.md "$out/README.md"
}

check_figures() {
    check "README's tables" readme_is_current
    if [ "$(head -n 1 $here/figures.tsv)" = "$(compilers)" ]; then
        check "figures as committed" unchanged
    else
        echo "figures not compared: other compilers"
    fi
}

measure_all() {
    rm -rf "$out"
    mkdir -p "$out"
    compilers >"$out/figures.tsv"
    check "streams" make_streams
    check "plugin" cc -O2 -shared -fPIC $here/count.c -o "$out/libcount.so"
    test_process host "disc small grid random regular" "" cc -O2
    test_device cortex-m3 grid random
    test_device cortex-m0 disc
    test_device rv32 grid random
    test_all
    test_display
    test_door
    check "memory" measure_memory
}

case ${1-} in
check)
    measure_all
    grep -E "^[ '.:]{128}$" "$out/cortex-m3/torus.txt" | grep '[^ ]'
    test_compilers
    check_budgets
    check_figures ;;
figures)
    measure_all
    cp "$out/figures.tsv" $here/figures.tsv
    bench=build/bench/results.csv
    [ -e $bench ] || bench=
    # shellcheck disable=SC2086 # none if it is empty
    $here/readme.py README.md $here/figures.tsv $here/budgets.tsv $bench ;;
*)
    echo "usage: embedded.sh check | figures" >&2
    exit 2 ;;
esac
echo "$passed passed, $failed failed"
[ $failed -eq 0 ] && [ $passed -gt 0 ]
