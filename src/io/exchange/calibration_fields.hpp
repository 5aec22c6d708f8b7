#pragma once
/// Fields of other programs' calibrations: the names and spellings in which they write matrices, sizes and lenses.
#include <optional>
#include <vector>

#include "document/value.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::io::calibration {

using Names = std::vector<const char*>;

constexpr const char* kNextCalibration =
    "give K (or camera_matrix), D (or distortion_coefficients) and the image's size; docs/exchange.md lists "
    "the formats";

/// The first member with one of these names; nullopt when there is none.
std::optional<Value> find(const Value& object, const Names& names);
/// The same whatever the case and without '_', '-' and blanks: "Camera_Matrix" and "cameraMatrix" are "cameramatrix".
std::optional<Value> find_spelled(const Value& object, const Names& names);
Value require_member(const Value& object, const Names& names, const char* next = kNextCalibration);
/// The number of a member that must be there.
double require_number(const Value& object, const Names& names);
bool is_group(const Value& value);
/// true, or a number other than zero.
bool is_set(const std::optional<Value>& flag);

/// A matrix in any of its spellings, row by row: {rows, cols, data}, a list of rows, or its numbers alone.
struct Numbers {
  std::vector<double> values;
  std::size_t rows = 0, columns = 0;  ///< zero where the file does not say
};
Numbers numbers_of(const Value& value);
/// rows x columns numbers; a flat list is taken row by row.
MatX matrix_of(const Value& value, std::size_t rows, std::size_t columns);

/// fx, fy, cx, cy, or the 3x3 matrix [fx skew cx; 0 fy cy; 0 0 1].
Intrinsics intrinsics_of(const Value& value);
/// Throws Error(kInput) unless both focal lengths are positive.
void check_focal_lengths(const Value& where, const Intrinsics& intrinsics);
/// The size `width` x `height` that is in `value`.
ImageSize size_in(const Value& value, double width, double height);
std::optional<ImageSize> size_of(const Value& camera);
ImageSize required_size(const std::optional<ImageSize>& in_file, const std::optional<ImageSize>& given,
                        const Value& where, const char* device);

/// `coefficients` in OpenCV's order, or a group with k1, k2, ... by name, of the model that `model` names (plain when it
/// is absent). `camera` is where their absence is reported.
Distortion distortion_of(const Value& camera, const std::optional<Value>& coefficients,
                         const std::optional<Value>& model, bool fisheye);

/// Throws Error(kInput) where a member looks like a lens's distortion: nobody asked for it, and without it all pixels are
/// wrong.
void refuse_unread_distortion(const Value& camera);

/// Are these three columns a rotation, but for the rounding of numbers with five decimals?
bool is_rotation(const Mat3& matrix);
/// The rotation and translation of a rigid 4x4 matrix. Throws Error(kInput) with `next` for any other.
Pose rigid_transform_of(const Value& matrix, const char* next);

}  // namespace procam::io::calibration
