#pragma once

/// Before a function of plain loops over arrays: it is compiled for processors with AVX2 as well, and which of the two
/// runs is chosen when the program starts. AVX2 does not bring fused multiplications, so both give the same bits.
/// Needs glibc. Not under the thread sanitizer: the choice is made before its library can be called.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define MESHLOOP_TARGET_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define MESHLOOP_TARGET_CLONES
#endif
