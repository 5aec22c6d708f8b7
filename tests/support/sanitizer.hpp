#pragma once
/// Defines PROCAM_ADDRESS_SANITIZER or PROCAM_THREAD_SANITIZER where the tests are built with that sanitizer: Clang tells it
/// by __has_feature, GCC by macros of its own.

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define PROCAM_ADDRESS_SANITIZER
#endif
#if __has_feature(thread_sanitizer)
#define PROCAM_THREAD_SANITIZER
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) && !defined(PROCAM_ADDRESS_SANITIZER)
#define PROCAM_ADDRESS_SANITIZER
#endif
#if defined(__SANITIZE_THREAD__) && !defined(PROCAM_THREAD_SANITIZER)
#define PROCAM_THREAD_SANITIZER
#endif
