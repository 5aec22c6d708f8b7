#pragma once
/// PROCAM_EXPORT: marks a function or class whose body is in a library. The libraries hide every other symbol, so that
/// what programs can link is what the public headers declare, and so that two libraries' helpers of one name never meet.
/// Headers alone (core) need no mark.

#if defined(__GNUC__)
#define PROCAM_EXPORT __attribute__((visibility("default")))
#else
#define PROCAM_EXPORT
#endif
