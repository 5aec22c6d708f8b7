#pragma once
/// Between numpy and procam: images, points, vectors, matrices and quaternions.
///
///   image            uint8, uint16, int16 or float32, (h, w) or (h, w, c), rows at any positive distance: looked at in
///                    place; any other layout in memory is copied for the call
///   image to fill    the same, writable, never copied
///   Points2, Points3 float64 (n, 2), (n, 3)
///   vector, matrix   float64 (n,), (r, c)
///   quaternion       float64 (4,), x y z w
///   aligned box      float64 (2, 2), low corner, high corner
///
/// An argument of another type or shape is refused with the argument's name, the expected and the found shape.
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <climits>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::python {

namespace py = pybind11;

using Triangles = std::vector<std::array<int, 3>>;

/// An argument's name for messages: "fit_homography: source".
struct Where {
  const char* function = "";
  const char* argument = "";

  std::string text() const {
    const std::string name = function;
    return (name.empty() ? name : name + ": ") + argument;
  }
};

/// "float64 array of shape (4, 3)", "str", "None".
std::string description(py::handle object);

/// TypeError or ValueError: "fit_homography: source: expected ..., found ...".
[[noreturn]] void refuse_type(const Where& where, const std::string& expected, py::handle found);
[[noreturn]] void refuse_shape(const Where& where, const std::string& expected, py::handle found);

/// The object as a float64 array, rows without gaps. `expected` is for the message.
py::array_t<double, py::array::c_style> numbers(py::handle object, const Where& where,
                                                const std::string& expected);

/// Does each pixel follow the one before, at the natural alignment of its type?
bool is_image_in_place(const py::array& array);

/// Keeps the object until the current call into C++ returns.
void keep_for_call(py::handle object);

/// A container's copy must not look like the field: lists become tuples, dictionaries read-only views, arrays read-only.
py::object frozen(py::object value);

template <typename T>
const char* type_name();
template <>
inline const char* type_name<std::uint8_t>() {
  return "uint8";
}
template <>
inline const char* type_name<std::uint16_t>() {
  return "uint16";
}
template <>
inline const char* type_name<std::int16_t>() {
  return "int16";
}
template <>
inline const char* type_name<float>() {
  return "float32";
}

// ---------------------------------------------------------------------------------------------------------------------
// Loader<T>: from(object, where) -> T, and name(), the type in signatures.

template <typename T>
struct Loader;

template <typename T>
std::string image_expected(const char* kind = "") {
  return std::string(kind) + type_name<T>() + " array of shape (h, w) or (h, w, c)";
}

template <typename T>
py::array image_array(py::handle object, const Where& where, const std::string& expected) {
  if (!py::isinstance<py::array>(object)) refuse_type(where, expected, object);
  if (!py::isinstance<py::array_t<T, 0>>(object)) refuse_type(where, expected, object);
  py::array array = py::reinterpret_borrow<py::array>(object);
  if (array.ndim() != 2 && array.ndim() != 3) refuse_shape(where, expected, object);
  for (py::ssize_t i = 0; i < array.ndim(); ++i)
    if (array.shape(i) > INT_MAX) refuse_shape(where, expected, object);
  if (array.ndim() == 3 && array.shape(2) == 0) refuse_shape(where, expected, object);
  return array;
}

template <typename T, typename Pixel>
ImageView<T> view_in_place(const py::array& array, Pixel* pixels) {
  const int channels = array.ndim() == 3 ? int(array.shape(2)) : 1;
  const int width = int(array.shape(1)), height = int(array.shape(0));
  const bool one_row = height <= 1;
  return {pixels, width, height, channels, one_row ? 0 : array.strides(0) / py::ssize_t(sizeof(T))};
}

/// To look at.
template <typename T>
struct Loader<ImageView<const T>> {
  static ImageView<const T> from(py::handle object, const Where& where) {
    py::array array = image_array<T>(object, where, image_expected<T>());
    if (!is_image_in_place(array)) array = py::array_t<T, py::array::c_style>(array);
    keep_for_call(array);
    return view_in_place<const T>(array, static_cast<const T*>(array.data()));
  }
};

/// To fill.
template <typename T>
struct Loader<ImageView<T>> {
  static ImageView<T> from(py::handle object, const Where& where) {
    const std::string expected = image_expected<T>("writable ") + ", each row without gaps";
    py::array array = image_array<T>(object, where, expected);
    if (!array.writeable() || !is_image_in_place(array)) refuse_type(where, expected, object);
    keep_for_call(array);
    return view_in_place<T>(array, static_cast<T*>(array.mutable_data()));
  }
};

template <typename T>
struct Loader<Image<T>> {
  static Image<T> from(py::handle object, const Where& where) {
    const py::array given = image_array<T>(object, where, image_expected<T>());
    const py::array_t<T, py::array::c_style> array(given);
    Image<T> image(int(array.shape(1)), int(array.shape(0)), array.ndim() == 3 ? int(array.shape(2)) : 1);
    if (!image.empty()) std::copy(array.data(), array.data() + array.size(), image.data());
    return image;
  }
};

template <int Size>
struct PointsLoader {
  static std::vector<Eigen::Matrix<double, Size, 1>> from(py::handle object, const Where& where) {
    const std::string expected = "float64 array of shape (n, " + std::to_string(Size) + ")";
    const auto array = numbers(object, where, expected);
    const bool none = array.size() == 0 && array.ndim() <= 2;
    if (!none && (array.ndim() != 2 || array.shape(1) != Size)) refuse_shape(where, expected, object);
    std::vector<Eigen::Matrix<double, Size, 1>> points(none ? 0 : std::size_t(array.shape(0)));
    if (!points.empty()) std::copy(array.data(), array.data() + array.size(), points.front().data());
    return points;
  }
};

template <>
struct Loader<Points2> : PointsLoader<2> {};
template <>
struct Loader<Points3> : PointsLoader<3> {};

template <int Rows, int Columns, int Options>
struct Loader<Eigen::Matrix<double, Rows, Columns, Options>> {
  using Matrix = Eigen::Matrix<double, Rows, Columns, Options>;

  static std::string expected() {
    const auto side = [](int n, const char* free) { return n == Eigen::Dynamic ? free : std::to_string(n); };
    std::string shape = "float64 array of shape (" + side(Rows, "n") + ",";
    if constexpr (Columns != 1) shape += " " + side(Columns, "m");
    return shape + ")";
  }
  static Matrix from(py::handle object, const Where& where) {
    const auto array = numbers(object, where, expected());
    const bool column = Columns == 1 && array.ndim() == 1;
    const py::ssize_t rows = array.ndim() > 0 ? array.shape(0) : 0;
    const py::ssize_t columns = column ? 1 : array.ndim() == 2 ? array.shape(1) : -1;
    if (columns < 0 || (Rows != Eigen::Dynamic && rows != Rows) ||
        (Columns != Eigen::Dynamic && columns != Columns))
      refuse_shape(where, expected(), object);
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const RowMajor>(array.data(), rows, columns);
  }
};

template <>
struct Loader<Eigen::Quaterniond> {
  static Eigen::Quaterniond from(py::handle object, const Where& where) {
    const std::string expected = "float64 array of shape (4,): x, y, z, w";
    const auto array = numbers(object, where, expected);
    if (array.ndim() != 1 || array.shape(0) != 4) refuse_shape(where, expected, object);
    return {array.at(3), array.at(0), array.at(1), array.at(2)};
  }
};

template <>
struct Loader<Eigen::AlignedBox2d> {
  static Eigen::AlignedBox2d from(py::handle object, const Where& where) {
    const Mat2 corners = Loader<Mat2>::from(object, where);
    return {Vec2(corners.row(0)), Vec2(corners.row(1))};
  }
};

template <>
struct Loader<Triangles> {
  static Triangles from(py::handle object, const Where& where);
};

/// Which of a list are used: numpy's bool.
template <>
struct Loader<std::vector<char>> {
  static std::vector<char> from(py::handle object, const Where& where);
};

template <typename T>
struct Loader<std::vector<ImageView<const T>>> {
  static std::vector<ImageView<const T>> from(py::handle object, const Where& where) {
    std::vector<ImageView<const T>> views;
    const py::sequence sequence = each(object, where);
    for (std::size_t i = 0; i < sequence.size(); ++i)
      views.push_back(Loader<ImageView<const T>>::from(py::object(sequence[i]), where));
    return views;
  }
  static py::sequence each(py::handle object, const Where& where) {
    if (!py::isinstance<py::sequence>(object) || py::isinstance<py::str>(object))
      refuse_type(where,
                  "sequence of " + std::string(type_name<T>()) + " arrays of shape (h, w) or (h, w, c)",
                  object);
    return py::reinterpret_borrow<py::sequence>(object);
  }
};

template <typename T>
struct Loader<std::vector<Image<T>>> {
  static std::vector<Image<T>> from(py::handle object, const Where& where) {
    std::vector<Image<T>> images;
    const py::sequence sequence = Loader<std::vector<ImageView<const T>>>::each(object, where);
    for (std::size_t i = 0; i < sequence.size(); ++i)
      images.push_back(Loader<Image<T>>::from(py::object(sequence[i]), where));
    return images;
  }
};

template <typename T, typename = void>
struct IsArray : std::false_type {};
template <typename T>
struct IsArray<T, std::void_t<decltype(&Loader<T>::from)>> : std::true_type {};

/// An array argument as it came; it is converted where its name is known (bind.hpp).
template <typename T>
struct Arg {
  py::handle object;
};

}  // namespace procam::python

namespace pybind11::detail {

/// Loads by Loader<T>, as part of a list, of an optional or of a variant.
template <typename T>
struct numpy_caster {
  bool load(handle source, bool) {
    if (!source || source.is_none()) return false;
    try {
      value_.emplace(procam::python::Loader<T>::from(source, {}));
    } catch (const builtin_exception&) {
      return false;
    }
    return true;
  }
  template <typename U>
  using cast_op_type = movable_cast_op_type<U>;
  operator T*() { return &*value_; }
  operator T&() { return *value_; }
  operator T&&() && { return std::move(*value_); }

 protected:
  std::optional<T> value_;
};

/// In signatures: one channel has the shape (h, w).
template <typename T>
constexpr auto image_name() {
  return const_name("numpy.ndarray[") + npy_format_descriptor<T>::name + const_name("[h, w, c]]");
}

template <typename T>
struct type_caster<procam::ImageView<T>> : numpy_caster<procam::ImageView<T>> {
  static constexpr auto name = image_name<std::remove_const_t<T>>();
  static handle cast(const procam::ImageView<T>& view, return_value_policy, handle) {
    using Pixel = std::remove_const_t<T>;
    std::vector<ssize_t> shape{view.height, view.width},
        strides{view.stride * ssize_t(sizeof(Pixel)), view.channels * ssize_t(sizeof(Pixel))};
    if (view.channels != 1) {
      shape.push_back(view.channels);
      strides.push_back(sizeof(Pixel));
    }
    return array_t<Pixel>(shape, strides, view.data).release();  // a copy
  }
};

template <typename T>
struct type_caster<procam::Image<T>> : numpy_caster<procam::Image<T>> {
  static constexpr auto name = image_name<T>();
  static handle cast(procam::Image<T>&& image, return_value_policy, handle) {
    auto* const owned = new procam::Image<T>(std::move(image));
    const capsule owner(owned, [](void* pointer) { delete static_cast<procam::Image<T>*>(pointer); });
    std::vector<ssize_t> shape{owned->height(), owned->width()};
    if (owned->channels() != 1) shape.push_back(owned->channels());
    return array_t<T>(shape, owned->data(), owner).release();
  }
  static handle cast(const procam::Image<T>& image, return_value_policy policy, handle parent) {
    return cast(procam::Image<T>(image), policy, parent);
  }
  static handle cast(const procam::Image<T>* image, return_value_policy policy, handle parent) {
    return image != nullptr ? cast(*image, policy, parent) : none().release();
  }
};

template <int Size>
struct points_caster : numpy_caster<std::vector<Eigen::Matrix<double, Size, 1>>> {
  static constexpr auto name =
      const_name("numpy.ndarray[numpy.float64[n, ") + const_name<size_t(Size)>() + const_name("]]");
  static handle cast(const std::vector<Eigen::Matrix<double, Size, 1>>& points, return_value_policy, handle) {
    array_t<double> array({ssize_t(points.size()), ssize_t(Size)});
    if (!points.empty())
      std::copy(points.front().data(), points.front().data() + points.size() * Size, array.mutable_data());
    return array.release();
  }
};

template <>
struct type_caster<procam::Points2> : points_caster<2> {};
template <>
struct type_caster<procam::Points3> : points_caster<3> {};

template <>
struct type_caster<procam::python::Triangles> : numpy_caster<procam::python::Triangles> {
  static constexpr auto name = const_name("numpy.ndarray[numpy.int32[n, 3]]");
  static handle cast(const procam::python::Triangles& triangles, return_value_policy, handle) {
    array_t<std::int32_t> array({ssize_t(triangles.size()), ssize_t(3)});
    if (!triangles.empty())
      std::copy(triangles.front().data(), triangles.front().data() + 3 * triangles.size(),
                array.mutable_data());
    return array.release();
  }
};

template <>
struct type_caster<std::vector<char>> : numpy_caster<std::vector<char>> {
  static constexpr auto name = const_name("numpy.ndarray[bool[n]]");
  static handle cast(const std::vector<char>& flags, return_value_policy, handle) {
    array_t<bool> array(ssize_t(flags.size()));
    std::transform(flags.begin(), flags.end(), array.mutable_data(), [](char flag) { return flag != 0; });
    return array.release();
  }
};

template <>
struct type_caster<Eigen::Quaterniond> : numpy_caster<Eigen::Quaterniond> {
  static constexpr auto name = const_name("numpy.ndarray[numpy.float64[4, 1]]");
  static handle cast(const Eigen::Quaterniond& q, return_value_policy, handle) {
    array_t<double> array(4);
    std::copy(q.coeffs().data(), q.coeffs().data() + 4, array.mutable_data());
    return array.release();
  }
};

template <>
struct type_caster<Eigen::AlignedBox2d> : numpy_caster<Eigen::AlignedBox2d> {
  static constexpr auto name = const_name("numpy.ndarray[numpy.float64[2, 2]]");
  static handle cast(const Eigen::AlignedBox2d& box, return_value_policy policy, handle parent) {
    procam::Mat2 corners;
    corners << box.min().transpose(), box.max().transpose();
    return make_caster<procam::Mat2>::cast(corners, policy, parent);
  }
};

template <typename T>
struct type_caster<procam::python::Arg<T>> {
  PYBIND11_TYPE_CASTER(procam::python::Arg<T>, make_caster<T>::name);

  /// All but other types of procam, which have an overload of their own.
  bool load(handle source, bool) {
    if (get_type_info(Py_TYPE(source.ptr())) != nullptr) return false;
    value.object = source;
    return true;
  }
  static handle cast(const procam::python::Arg<T>& arg, return_value_policy, handle) {
    return arg.object.inc_ref();
  }
};

}  // namespace pybind11::detail
