#include "procam/core/base/bytes.hpp"

#include <gtest/gtest.h>

namespace procam {
namespace {

TEST(ByteReader, ReadsBothByteOrders) {
  const std::string_view bytes("\x01\x02\xff\x04", 4);
  EXPECT_EQ(ByteReader{bytes}.number<std::uint32_t>(), 0x04ff0201u);
  EXPECT_EQ(ByteReader{bytes}.number<std::uint32_t>(true), 0x0102ff04u);
  EXPECT_EQ(unsigned_at(bytes, 1, 2, true), 0x02ffu);
  EXPECT_EQ(unsigned_at(bytes, 1, 2, false), 0xff02u);
}

TEST(ByteReader, ReadsRealNumbers) {
  ByteReader big{std::string_view("\x3f\xc0\0\0\xbf\xf8\0\0\0\0\0\0", 12)};
  EXPECT_EQ(big.real32(true), 1.5);
  EXPECT_EQ(big.real64(true), -1.5);
  EXPECT_FALSE(big.bad);
  EXPECT_TRUE(big.rest.empty());
}

TEST(ByteReader, NeverLeavesTheBytes) {
  ByteReader reader{"abcde"};
  EXPECT_EQ(reader.take(3), "abc");
  EXPECT_EQ(reader.number<std::uint32_t>(), 0u);
  EXPECT_TRUE(reader.bad);
  EXPECT_EQ(reader.rest, "de") << "a failed read takes nothing";
  EXPECT_EQ(reader.take(1), "") << "after a failed read nothing is read";
  EXPECT_EQ(unsigned_at("abc", 2, 2, true), std::nullopt);
  EXPECT_EQ(unsigned_at("abc", std::size_t(-1), 2, true), std::nullopt);
  EXPECT_EQ(unsigned_at("abc", 3, 0, true), 0u);
}

}  // namespace
}  // namespace procam
