#include "procam/pattern/gray_code.hpp"

#include <algorithm>
#include "gray_code_bits.hpp"

namespace procam::pattern {
namespace {

void require_sound(const GrayCode& gray_code) {
  const ImageSize size = gray_code.projector_size;
  // Codes travel as 16-bit integers with -1 for undecoded.
  require(size.width >= 1 && size.height >= 1 && size.width <= 32767 && size.height <= 32767,
          "GrayCode: projector size " + std::to_string(size.width) + "x" + std::to_string(size.height) +
              " is outside 1..32767");
  require(gray_code.step >= 1, "GrayCode: step " + std::to_string(gray_code.step) + " is below 1");
}

}  // namespace

int stripe_count(const GrayCode& gray_code, StripeAxis axis) {
  require_sound(gray_code);
  const int size =
      axis == StripeAxis::kColumn ? gray_code.projector_size.width : gray_code.projector_size.height;
  return (size - 1) / gray_code.step + 1;
}

int bit_count(const GrayCode& gray_code, StripeAxis axis) {
  const int count = stripe_count(gray_code, axis);
  int bits = 0;
  while ((1 << bits) < count) ++bits;
  return bits;
}

int frame_count(const GrayCode& gray_code) {
  return 2 * (bit_count(gray_code, StripeAxis::kColumn) + bit_count(gray_code, StripeAxis::kRow)) + 2;
}

GrayCodeFrame frame_info(const GrayCode& gray_code, int index) {
  const int count = frame_count(gray_code);
  require(index >= 0 && index < count,
          "GrayCode: frame " + std::to_string(index) + " is outside 0.." + std::to_string(count - 1));
  if (index == count - 2) return {GrayCodeFrame::Kind::kWhite, 0, false};
  if (index == count - 1) return {GrayCodeFrame::Kind::kBlack, 0, false};
  const int column_bits = bit_count(gray_code, StripeAxis::kColumn);
  const int pair = index / 2;
  const bool inverse = index % 2 == 1;
  if (pair < column_bits) return {GrayCodeFrame::Kind::kColumnBit, column_bits - 1 - pair, inverse};
  const int row_bits = bit_count(gray_code, StripeAxis::kRow);
  return {GrayCodeFrame::Kind::kRowBit, row_bits - 1 - (pair - column_bits), inverse};
}

std::string frame_name(const GrayCode& gray_code, int index) {
  const GrayCodeFrame info = frame_info(gray_code, index);
  const std::string frame = "frame " + std::to_string(index);
  switch (info.kind) {
    case GrayCodeFrame::Kind::kWhite:
      return frame + " (white)";
    case GrayCodeFrame::Kind::kBlack:
      return frame + " (black)";
    case GrayCodeFrame::Kind::kColumnBit:
    case GrayCodeFrame::Kind::kRowBit:
      break;
  }
  const char* axis = info.kind == GrayCodeFrame::Kind::kColumnBit ? " (column bit " : " (row bit ";
  return frame + axis + std::to_string(info.bit) + (info.inverse ? ", inverse)" : ")");
}

ImageU8 frame(const GrayCode& gray_code, int index) {
  const GrayCodeFrame info = frame_info(gray_code, index);
  if (info.kind == GrayCodeFrame::Kind::kWhite) return ImageU8(gray_code.projector_size, 1, 255);
  if (info.kind == GrayCodeFrame::Kind::kBlack) return ImageU8(gray_code.projector_size, 1, 0);

  const auto level = [&](int pixel) {
    const unsigned code = unsigned(pixel / gray_code.step);
    const bool lit = (((code ^ (code >> 1)) >> info.bit) & 1u) != 0;
    return std::uint8_t(lit != info.inverse ? 255 : 0);
  };
  ImageU8 image(gray_code.projector_size);
  for (int y = 0; y < image.height(); ++y) {
    std::uint8_t* row = image.row(y);
    if (info.kind == GrayCodeFrame::Kind::kRowBit) {
      std::fill_n(row, image.width(), level(y));
    } else {
      for (int x = 0; x < image.width(); ++x) row[x] = level(x);
    }
  }
  return image;
}

std::vector<ImageU8> frames(const GrayCode& gray_code) {
  std::vector<ImageU8> all;
  const int count = frame_count(gray_code);
  all.reserve(std::size_t(count));
  for (int index = 0; index < count; ++index) all.push_back(frame(gray_code, index));
  return all;
}

std::string describe(const GrayCode& gray_code) {
  const ImageSize size = gray_code.projector_size;
  std::string text = std::to_string(frame_count(gray_code)) + " frames for " + std::to_string(size.width) +
                     "x" + std::to_string(size.height);
  if (gray_code.step > 1) text += " in steps of " + std::to_string(gray_code.step);
  return text + " (columns " + std::to_string(bit_count(gray_code, StripeAxis::kColumn)) + " bits, rows " +
         std::to_string(bit_count(gray_code, StripeAxis::kRow)) + " bits, white, black)";
}

}  // namespace procam::pattern
