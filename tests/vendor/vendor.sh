#!/bin/bash
# How other projects take conquest: installed, by pkg-config, by CMake, fetched, copied. The projects of this folder are
# built outside of the repository, with an installation that was moved. The last line is `N passed, N failed`.
#
#     tests/vendor/vendor.sh [windows]     windows: with mingw-w64, run by wine
set -u
cd "$(dirname "$0")/../.." || exit 1
root=$PWD
clang=${CLANG:-clang-19}
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
version=$(sed -n 's/^#define CQ_VERSION_STRING "\(.*\)".*/\1/p' include/conquest.h)
strict="-Wall -Wextra -Wconversion -pedantic -Werror"
own="main.c narrow.c own.c own_16.c"
passed=0 failed=0

check() {
    if "$@" >"$work/log" 2>&1; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAIL  $*"
        tail -n 8 "$work/log"
    fi
}

fails_with() { # words command...
    local words=$1
    shift
    ! "$@" >"$work/output" 2>&1 && grep -q "$words" "$work/output"
}

says_version() { # command...
    local output
    output=$("$@") && [ "${output%$'\r'}" = "$version" ]
}

# -- Installed -----------------------------------------------------------------------------------------------------

install_moved() {
    make -s install PREFIX="$work/first" && mv "$work/first" "$work/moved" && mkdir "$work/first"
}

# All options that the program tells of are in its manual page, which has no warnings of its own.
manual_is_complete() {
    local page=$work/moved/share/man/man1/cqm.1 option
    [ -z "$(LC_ALL=C man --warnings -l "$page" 2>&1 >"$work/page")" ] || return 1
    for option in $(for c in encode decode info verify; do "$work/moved/bin/cqm" $c --help; done |
            grep -o '^  --[a-z-]*'); do
        col -b <"$work/page" | grep -q -e "^ *$option" || { echo "no $option"; return 1; }
    done
    grep -q -e --bits "$work/page"
}

uninstall_leaves_nothing() {
    make -s install DESTDIR="$work/stage" PREFIX=/usr LIBDIR=/usr/lib/machine &&
        [ "$(find "$work/stage" -type f | wc -l)" = 7 ] &&
        make -s uninstall DESTDIR="$work/stage" PREFIX=/usr LIBDIR=/usr/lib/machine &&
        [ "$(find "$work/stage" -type f | wc -l)" = 0 ]
}

config() { PKG_CONFIG_PATH=$work/moved/lib/pkgconfig pkg-config --define-variable=prefix="$work/moved" "$@" conquest; }

by_pkg_config() { # command...
    # shellcheck disable=SC2046,SC2086 # flags are words
    "$@" $strict main.c narrow.c $(config --cflags --libs) -o "$work/program" && says_version "$work/program"
}

# -- CMake ---------------------------------------------------------------------------------------------------------

by_cmake() { # project language options...
    local project=$1 language=$2 folder=$work/build-$1-$2
    shift 2
    cmake -S "$work/vendor/$project" -B "$folder" -DLANGUAGE="$language" "$@" && cmake --build "$folder" &&
        says_version "$folder/with_library" && says_version "$folder/with_header"
}

# `cmake --install` gives the package of `make install`, which works in the same way.
cmake_installs() {
    cmake -S "$root/examples/cmake" -B "$work/own" -DCMAKE_INSTALL_PREFIX="$work/other" -DCMAKE_INSTALL_LIBDIR=lib &&
        cmake --build "$work/own" && cmake --install "$work/own" &&
        diff <(cd "$work/other" && find . -type f | sort) \
             <(cd "$work/moved" && find . -type f ! -path '*/bin/*' ! -path '*/man/*' | sort) &&
        diff -r -x '*.a' -x '*.pc' "$work/other/lib" "$work/moved/lib" &&
        [ "$(PKG_CONFIG_PATH=$work/other/lib/pkgconfig pkg-config --variable=includedir conquest)" = \
            "$work/other/include" ]
}

# -- Warnings ------------------------------------------------------------------------------------------------------

gcc_flags="-O1 -Wall -Wextra -pedantic -Wconversion -Wshadow -Wundef -Wcast-qual -Wcast-align -Wdouble-promotion"
gcc_cxx_flags="$gcc_flags -Wold-style-cast -Wuseless-cast -Wzero-as-null-pointer-constant"

# Names of the warnings of the implementation, each once, as a line "clang c++ -Wname".
warnings() { # include-flag
    local include=$1
    gcc -std=c99 $gcc_flags "$include" include -c "$work/vendor/own.c" -o "$work/o" 2>&1 | named gcc c
    g++ -x c++ -std=c++17 $gcc_cxx_flags "$include" include -c "$work/vendor/own.c" -o "$work/o" 2>&1 | named gcc c++
    "$clang" -std=c99 -Weverything "$include" include -c "$work/vendor/own.c" -o "$work/o" 2>&1 | named clang c
    "$clang" -x c++ -std=c++17 -Weverything -Wno-c++98-compat-pedantic "$include" include -c "$work/vendor/own.c" \
        -o "$work/o" 2>&1 | named clang c++
}

named() { grep -E ' (error|warning): ' | sed -E "s/.*\[(-W[a-z0-9+-]*)[^]]*\]$/\1/; s/^/$1 $2 /" | sort -u; }
silent_as_system_header() { [ -z "$(warnings -isystem | tee /dev/stderr)" ]; }
warns_as_listed() { diff <(grep -v '^#' "$root/tests/vendor/warnings.txt" | sort) <(warnings -I | sort); }

# -- Copied, by other compilers ------------------------------------------------------------------------------------

copied() { # command...
    # shellcheck disable=SC2086 # names are words
    "$@" $strict -I"$root/include" $own -o "$work/program" && says_version "$work/program"
}

# Flags of Microsoft's compiler, as clang-cl understands them. No linking: its libraries are not to be had.
microsoft() { # target flags...
    local target=$1 unit
    shift
    for unit in $own; do
        rm -f "$work/unit.obj"
        "$clang" --driver-mode=cl --target="$target" "$@" /W4 /WX /Od /clang:-ffreestanding -I"$root/include" \
            -I"$work/stubs" /c "$unit" "/Fo$work/unit.obj" && [ -s "$work/unit.obj" ] || return 1
    done
}

run_native() {
    check install_moved
    check cmp include/conquest.h "$work/moved/include/conquest.h"
    check manual_is_complete
    check says_version config --modversion
    check uninstall_leaves_nothing
    check silent_as_system_header
    check warns_as_listed
    cd "$work/vendor" || exit 1
    for compiler in gcc "$clang"; do
        check by_pkg_config $compiler -std=c99
        check by_pkg_config $compiler -x c++ -std=c++17
        check copied $compiler -std=c99
        check copied $compiler -x c++ -std=c++17
        check copied $compiler -std=c99 -m32
    done
    for target in x86_64 i686 aarch64; do
        check microsoft $target-pc-windows-msvc
        check microsoft $target-pc-windows-msvc /TP /std:c++17
    done
    for language in C CXX; do
        check by_cmake package $language -DCMAKE_PREFIX_PATH="$work/moved"
        check by_cmake fetch $language -DARCHIVE="$work/conquest.tar.gz"
    done
    check cmake_installs
    for asked in 0.1 0.2.9 0.3 1; do
        check fails_with 'compatible with requested' \
            cmake -S package -B "$work/refused" -DCMAKE_PREFIX_PATH="$work/moved" -DASKED=$asked
    done
}

# with_library.exe and with_header.exe under wine.
by_mingw() {
    cmake -S "$work/vendor/fetch" -B "$work/mingw" -DLANGUAGE=C -DARCHIVE="$work/conquest.tar.gz" \
        -DCMAKE_SYSTEM_NAME=Windows -DCMAKE_C_COMPILER=x86_64-w64-mingw32-gcc &&
        cmake --build "$work/mingw" && says_version in_wine "$work/mingw/with_library.exe" &&
        says_version in_wine "$work/mingw/with_header.exe"
}

in_wine() { WINEPREFIX=$work/wine WINEDEBUG=-all wine "$@"; }

cp -r tests/vendor "$work/vendor"
mkdir "$work/stubs"
printf '#ifdef __cplusplus\nextern "C" {\n#endif\n%s\n%s\n%s\n#ifdef __cplusplus\n}\n#endif\n' \
    'void *memcpy(void *, const void *, size_t); void *memset(void *, int, size_t); int puts(const char *);' \
    'int snprintf(char *, size_t, const char *, ...);' \
    'int memcmp(const void *, const void *, size_t); int strcmp(const char *, const char *);' >"$work/stubs/string.h"
touch "$work/stubs/stdio.h"
tar -czf "$work/conquest.tar.gz" --transform 's,^,conquest/,' include examples/cmake LICENSE
if [ "${1:-}" = windows ]; then check by_mingw; else run_native; fi
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed != 0 ]
