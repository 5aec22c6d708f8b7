#include "procam/core/base/parallel.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace procam {
namespace {

TEST(Parallel, EachIsCalledOnceWhateverTheThreads) {
  for (const int threads : {0, 1, 2, 5, 40})
    for (const int count : {0, 1, 3, 17}) {
      std::vector<std::atomic<int>> calls(std::size_t(count) + 1);
      parallel_each(count, threads, [&](int i) { ++calls[std::size_t(i)]; });
      parallel_for(count, threads, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) ++calls[std::size_t(i)];
      });
      for (int i = 0; i < count; ++i) EXPECT_EQ(calls[std::size_t(i)], 2) << threads << " " << count;
      EXPECT_EQ(calls.back(), 0);
    }
}

TEST(Parallel, MoreThreadsThanTheLimitAreNotStarted) {
  EXPECT_EQ(thread_count(limits::kThreads), limits::kThreads);
  EXPECT_EQ(thread_count(limits::kThreads + 1), limits::kThreads);
  EXPECT_EQ(thread_count(1000000), limits::kThreads);
  EXPECT_GE(thread_count(0), 1);
}

TEST(Parallel, TheFirstExceptionIsThrownAgain) {
  std::atomic<int> calls{0};
  const auto work = [&](int i) {
    ++calls;
    if (i == 2 || i == 6) throw std::runtime_error(std::to_string(i));
  };
  try {
    parallel_each(8, 3, work);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "2");
  }
  EXPECT_EQ(calls, 8);
  EXPECT_THROW(parallel_for(8, 3, [&](int begin, int) { work(begin); }), std::runtime_error);
}

}  // namespace
}  // namespace procam
