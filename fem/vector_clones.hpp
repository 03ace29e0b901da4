#pragma once

/// Before a function at namespace scope: it is compiled for AVX-512, for AVX2 and for the processor
/// that everything is compiled for, and the loader takes what this one has. Contraction is off, so
/// each gives the same bits. What the function calls counts only where it is inlined. Sanitizers
/// instrument what chooses, which runs before they are ready.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__linux__) &&       \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TACTUS_VECTOR_CLONES [[gnu::target_clones("avx512f", "avx2", "default")]]
#else
#define TACTUS_VECTOR_CLONES
#endif
