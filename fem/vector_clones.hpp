#pragma once

/// Placed before a function at namespace scope: the function is compiled for AVX-512, for AVX2 and
/// for the baseline processor, and the loader selects the version for this machine. Contraction is
/// off, so all versions give bit-equal results. Called functions are included only if they are
/// inlined. Not with sanitizers, whose instrumentation of the selecting function would run before
/// they are initialised.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__linux__) &&       \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TACTUS_VECTOR_CLONES [[gnu::target_clones("avx512f", "avx2", "default")]]
#else
#define TACTUS_VECTOR_CLONES
#endif
