#pragma once

/// Whether this build looks for faults of memory and undefined behaviour, which takes about four
/// times as long: then cases that measure at length what shorter ones run, too, are left out
/// (doctest::skip(kSanitized)), and meshes are coarser.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif
