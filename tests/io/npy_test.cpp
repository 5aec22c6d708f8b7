#include "image/npy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "procam/io/csv_table.hpp"
#include "support/expect_error.hpp"

namespace procam::io {
namespace {

/// A file as numpy.save() writes it: the header padded with blanks to a multiple of 64 bytes.
std::string numpy_file(const std::string& header, const std::string& data, int version = 1) {
  std::string padded = header;
  const std::size_t begin = version == 1 ? 10 : 12;
  while ((begin + padded.size() + 1) % 64 != 0) padded += ' ';
  padded += '\n';
  std::string bytes("\x93NUMPY", 6);
  bytes += {char(version), '\0', char(padded.size() & 0xff), char(padded.size() >> 8)};
  if (version > 1) bytes += std::string(2, '\0');
  return bytes + padded + data;
}

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

TEST(Npy, ReadsWhatNumpyWrites) {
  const NpyArray floats = parse_npy(numpy_file("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }",
                                               bytes_of<float>({0.5f, -1.25f, 3, 4, 1e20f, 6})),
                                    "a.npy");
  EXPECT_EQ(floats.shape, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(floats.values, (std::vector<double>{0.5, -1.25, 3, 4, double(1e20f), 6}));

  const NpyArray counts = parse_npy(numpy_file("{'descr': '<u2', 'fortran_order': False, 'shape': (3,), }",
                                               bytes_of<std::uint16_t>({0, 1, 65535})),
                                    "b.npy");
  EXPECT_EQ(counts.shape, std::vector<std::size_t>{3});
  EXPECT_EQ(counts.values, (std::vector<double>{0, 1, 65535}));

  // np.array([(7, -2, .25)], dtype=[('view', '<i4'), ('point', '<i8'), ('u', '<f8')]) in format 2.0
  const NpyArray table = parse_npy(
      numpy_file("{'descr': [('view', '<i4'), ('point', '<i8'), ('u', '<f8')], 'fortran_order': False, "
                 "'shape': (1,), }",
                 bytes_of<std::int32_t>({7}) + bytes_of<std::int64_t>({-2}) + bytes_of<double>({0.25}), 2),
      "c.npy");
  EXPECT_EQ(table.columns, (std::vector<std::string>{"view", "point", "u"}));
  EXPECT_EQ(table.shape, (std::vector<std::size_t>{1, 3}));
  EXPECT_EQ(table.values, (std::vector<double>{7, -2, 0.25}));
}

TEST(Npy, WritesNumpysLayoutAndReadsItBack) {
  const NpyArray plain{{2, 1, 2}, {0.1, -0.0, 1e300, 5e-324}, {}};
  const std::string bytes = format_npy(plain);
  EXPECT_EQ(bytes.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
  EXPECT_NE(bytes.find("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 1, 2, ), }"),
            std::string::npos);
  EXPECT_EQ((bytes.size() - 4 * sizeof(double)) % 64, 0u);  // where the numbers begin
  EXPECT_EQ(bytes[bytes.size() - 4 * sizeof(double) - 1], '\n');
  const NpyArray again = parse_npy(bytes, "p.npy");
  EXPECT_EQ(again.shape, plain.shape);
  EXPECT_EQ(again.values, plain.values);

  const NpyArray table{{2, 2}, {1, 2, 3, 4}, {"u", "v"}};
  const NpyArray read = parse_npy(format_npy(table), "t.npy");
  EXPECT_EQ(read.columns, table.columns);
  EXPECT_EQ(read.shape, table.shape);
  EXPECT_EQ(read.values, table.values);
}

TEST(Npy, RefusesWhatItCannotMean) {
  const auto file = [](const std::string& descr, const std::string& shape, std::size_t bytes,
                       const std::string& order = "False") {
    return numpy_file("{'descr': " + descr + ", 'fortran_order': " + order + ", 'shape': " + shape + ", }",
                      std::string(bytes, '\0'));
  };
  EXPECT_ERROR(parse_npy("PK\x03\x04 an .npz archive", "a"), kInput, "no .npy file");
  EXPECT_ERROR(parse_npy(file("'>f8'", "(1,)", 8), "a"), kUnsupported, "big-endian");
  EXPECT_ERROR(parse_npy(file("'<U8'", "(1,)", 32), "a"), kUnsupported, "'<U8'");
  EXPECT_ERROR(parse_npy(file("'|O'", "(1,)", 8), "a"), kUnsupported, "'|O'");
  EXPECT_ERROR(parse_npy(file("'<f8'", "(2, 2)", 32, "True"), "a"), kUnsupported, "Fortran");
  EXPECT_ERROR(parse_npy(file("'<f8'", "(2, 2)", 24), "a"), kInput, "24 bytes of numbers where");
  EXPECT_ERROR(parse_npy(file("'<f8'", "(4294967296, 4294967296)", 8), "a"), kInput, "claims more than");
  EXPECT_ERROR(parse_npy(file("'<f8'", "(1,1,1,1)", 8), "a"), kUnsupported, "three dimensions");
  EXPECT_ERROR(parse_npy(file("[('u', '<f8', (2,))]", "(1,)", 16), "a"), kUnsupported, "holds arrays");
  EXPECT_ERROR(parse_npy(numpy_file("{'descr': '<i8', 'fortran_order': False, 'shape': (1,)}",
                                    bytes_of<std::int64_t>({(std::int64_t(1) << 53) + 2})),
                         "a"),
               kInput, "beyond 2^53");
  EXPECT_THROW(format_npy({{3}, {1, 2}, {}}), std::invalid_argument);
}

/// Numbers come back; a column with one empty cell is real, and the cell NaN. A test in Python loads texts as well.
TEST(Npy, HasTheColumnsOfATable) {
  const NpyArray table = parse_npy(
      npy_of_csv("point,x,\"residual, px\"\r\n7,1.5,-2e-3\n-12,,4\n\n9007199254740991,3,0"), "t.npy");
  EXPECT_EQ(table.columns, (std::vector<std::string>{"point", "x", "residual, px"}));
  ASSERT_EQ(table.shape, (std::vector<std::size_t>{3, 3}));
  EXPECT_EQ(table.values[0], 7);
  EXPECT_EQ(table.values[1], 1.5);
  EXPECT_EQ(table.values[2], -2e-3);
  EXPECT_EQ(table.values[3], -12);
  EXPECT_TRUE(std::isnan(table.values[4]));
  EXPECT_EQ(table.values[6], 9007199254740991.0);
  const std::string texts = npy_of_csv("view,note\na,\"say \"\"no\"\"\"\nlonger,\n");
  EXPECT_NE(texts.find("[('view', '<U6'), ('note', '<U8')]"), std::string::npos) << texts.substr(0, 120);
  EXPECT_EQ(texts.substr(texts.size() - 4 * 14, 8), std::string("l\0\0\0o\0\0\0", 8));
  EXPECT_EQ(texts.substr(texts.size() - 4 * 8), std::string(4 * 8, '\0'));
  EXPECT_NE(npy_of_csv("x\n").find("'shape': (0,)"), std::string::npos);
  EXPECT_ERROR(npy_of_csv(""), kInput, "no header line");
  EXPECT_ERROR(npy_of_csv("a,b\n1\n"), kInput, "row 1 has 1 cells");
  EXPECT_ERROR(npy_of_csv("a\n\"1\n"), kInput, "does not end");
}

TEST(Npy, SurvivesDamage) {
  const std::string whole = format_npy({{4, 2}, {1, 2, 3, 4, 5, 6, 7, 8}, {"u", "v"}});
  std::mt19937 random(5);
  for (int trial = 0; trial < 4000; ++trial) {
    std::string bytes = whole;
    for (int hit = 0; hit < 1 + trial % 4; ++hit) bytes[random() % 140 % bytes.size()] = char(random() % 256);
    if (trial % 5 == 0) bytes.resize(random() % bytes.size());
    try {
      const NpyArray array = parse_npy(bytes, "damaged");
      EXPECT_LE(array.values.size(), 64u);
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace procam::io
