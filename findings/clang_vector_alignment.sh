#!/usr/bin/env bash
# Clang reads a reference to a vector type with lowered alignment by aligned moves; GCC reads it by unaligned ones.
#
# Surprise: aligned(8) in the alias of a vector type lowers its alignment, which both compilers state by alignof: 8. Clang
#   forgets it where the alias is the type of a parameter, and emits vmovaps, which needs 32 bytes. It keeps it where the same
#   type is loaded through a cast in the body, and emits vmovups. A program that passes such references fails at addresses that
#   the type allows. This script compiles and reads the assembly; it runs nothing.
# Versions: ziglang 0.17.1 (Clang 22.1), GCC 12 of Debian 12; the same with Clang 14 and 16 of Debian 12
# Seen: 2026-11
# Do: keep the natural alignment in the type, and load from other places by memcpy or by a struct with packed.
# Source: GCC manual, "Common Type Attributes", aligned: in a typedef it may lower the alignment. Clang language extensions,
#   "Vectors and Extended Vectors": GCC's vector extension is supported.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ziglang==0.17.1
dpkg-query --show --showformat='g++ ${Version}\n' g++ || { echo "needs g++ 12 or later (Debian: g++)"; exit 1; }
echo "zig $(venv/bin/python -m ziglang version), $(venv/bin/python -m ziglang c++ --version | head -n 1)"

cat > vector.cpp <<'EOF'
using Four __attribute__((vector_size(32), aligned(8))) = double;
static_assert(alignof(Four) == 8);
extern "C" void parameter(const Four& from, Four& to) { to = from; }
extern "C" void cast(const double* from, double* to) {
    *reinterpret_cast<Four*>(to) = *reinterpret_cast<const Four*>(from);
}
EOF
export ZIG_GLOBAL_CACHE_DIR=$work/zig ZIG_LOCAL_CACHE_DIR=$work/zig
venv/bin/python -m ziglang c++ -target x86_64-linux-gnu -mcpu=x86_64_v3 -std=c++20 -O2 -fno-sanitize=all -S vector.cpp \
    -o clang.s 2> log || { cat log; exit 1; }
g++ -std=c++20 -O2 -march=haswell -S vector.cpp -o gcc.s

moves() {  # assembly, function: the moves of 32 bytes in it
    awk -v begin="$2:" '$1 == begin { on = 1 } on && /^[ \t]*ret/ { exit } on && /^[ \t]*vmov/ { print $1 }' "$1" |
        sort -u | tr '\n' ' '
}
status=0
check() {  # assembly, function, pattern
    local seen
    seen=$(moves "$1" "$2")
    if [[ $seen =~ ^(($3)\ )+$ ]]; then
        echo "${1%.s}, $2: $seen"
    else
        echo "${1%.s}, $2: $seen CHANGED, was $3"
        status=1
    fi
}
check gcc.s parameter 'vmovup[sd]|vmovdqu'
check gcc.s cast 'vmovup[sd]|vmovdqu'
check clang.s parameter 'vmovap[sd]'
check clang.s cast 'vmovup[sd]'
exit $status
