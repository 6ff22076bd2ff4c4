#!/usr/bin/env bash
# no_weak_code.sh NM ARCHIVE PREFIX KERNELS: the objects compiled for one instruction set (PREFIXavx2.cpp.o and so on) must not
# emit inline functions that the linker may choose for the whole program: one of a shared header, compiled with AVX-512, would
# stop an older machine.
set -euo pipefail
symbols=$("$1" -A -C "$2" | grep ":$3\(sse\|four\|avx2\|avx512\)\.cpp\.o:" || true)
sets=$(grep -c " T etendue::$4" <<<"$symbols" || true)
[ "$sets" = 3 ] || { echo "$2 has the kernels of $sets instruction sets, expected 3"; exit 1; }
if grep ' W ' <<<"$symbols"; then
  echo "the functions above are weak symbols of files compiled for one instruction set; expected none"
  exit 1
fi
