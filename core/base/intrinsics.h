// Vector intrinsics of the compiler, if the processor has them.
#pragma once

#if defined(__SSE2__)
#if defined(__GNUC__) && !defined(__clang__)
// GCC 12 warns of undefined vectors in its own AVX-512 header.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#pragma GCC diagnostic pop
#else
#include <immintrin.h>
#endif
#endif
