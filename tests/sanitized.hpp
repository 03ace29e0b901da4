#pragma once

/// Whether this build looks for faults of memory and undefined behaviour (TACTUS_SANITIZE), which
/// takes about four times as long: then cases that measure at length what shorter ones run, too,
/// are left out (doctest::skip(kSanitized)), and meshes are coarser.
inline constexpr bool kSanitized = TACTUS_SANITIZED;
