#pragma once
/// Counts what a test program asks of the heap; to be included by one source of it. The thread sanitizer has operators of
/// its own: nothing is counted there (kAllocationsAreCounted).
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

#include "sanitizer.hpp"

namespace procam::test {

inline std::atomic<long> allocations{0};           ///< of all threads
inline thread_local long allocations_of_this = 0;  ///< of this thread

inline void* counted_memory(std::size_t size, std::size_t alignment) {
  ++allocations;
  ++allocations_of_this;
  void* const memory = std::aligned_alloc(alignment, (size + alignment) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace procam::test

#ifdef PROCAM_THREAD_SANITIZER
constexpr bool kAllocationsAreCounted = false;
#else
constexpr bool kAllocationsAreCounted = true;
void* operator new(std::size_t size) {
  return procam::test::counted_memory(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return procam::test::counted_memory(size, std::size_t(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
#endif
