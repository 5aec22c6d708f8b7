#pragma once
/// PROCAM_EXPORT: marks a function or class whose body is in a library. The libraries hide every other symbol, so that
/// what programs can link is what the public headers declare, and so that two libraries' helpers of one name never meet.
///
/// The longer functions of core are compiled once, into the library procam_core, where PROCAM_CORE_COMPILED is defined:
/// procam::core of CMake and procam-core of pkg-config define it. Without it each header includes its bodies
/// (detail/*_body.hpp) as inline functions, so the headers alone are enough; a file that includes them compiles longer.

#if defined(__GNUC__)
#define PROCAM_EXPORT __attribute__((visibility("default")))
#else
#define PROCAM_EXPORT
#endif

#ifdef PROCAM_CORE_COMPILED
#define PROCAM_CORE_INLINE
#else
#define PROCAM_CORE_INLINE inline
#endif
