#include "convert.hpp"

namespace procam::python {

std::string description(py::handle object) {
  if (object.is_none()) return "None";
  if (!py::isinstance<py::array>(object)) return Py_TYPE(object.ptr())->tp_name;
  const auto array = py::reinterpret_borrow<py::array>(object);
  std::string text = py::str(array.dtype()).cast<std::string>() + " array of shape " +
                     py::str(array.attr("shape")).cast<std::string>();
  if (!array.writeable()) text += ", read-only";
  if ((array.flags() & py::array::c_style) == 0) text += ", not C-contiguous";
  return text;
}

void refuse_type(const Where& where, const std::string& expected, py::handle found) {
  throw py::type_error(where.text() + ": expected " + expected + ", found " + description(found));
}

void refuse_shape(const Where& where, const std::string& expected, py::handle found) {
  throw py::value_error(where.text() + ": expected " + expected + ", found " + description(found));
}

py::array_t<double, py::array::c_style> numbers(py::handle object, const Where& where,
                                                const std::string& expected) {
  if (!object || object.is_none() || py::isinstance<py::str>(object) || py::isinstance<py::dict>(object))
    refuse_type(where, expected, object);
  const auto as_array = py::reinterpret_steal<py::object>(
      py::detail::npy_api::get().PyArray_FromAny_(object.ptr(), nullptr, 0, 0, 0, nullptr));
  if (!as_array) {
    PyErr_Clear();
    refuse_type(where, expected, object);
  }
  const char kind = py::reinterpret_borrow<py::array>(as_array).dtype().kind();
  const bool empty = py::reinterpret_borrow<py::array>(as_array).size() == 0;
  if (!empty && kind != 'f' && kind != 'i' && kind != 'u') refuse_type(where, expected, as_array);
  return py::array_t<double, py::array::c_style | py::array::forcecast>(as_array);
}

bool is_image_in_place(const py::array& array) {
  const py::ssize_t item = array.itemsize();
  const bool has_channels = array.ndim() == 3;
  const py::ssize_t channels = has_channels ? array.shape(2) : 1;
  if (array.size() == 0) return true;
  if ((array.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) == 0) return false;
  if (has_channels && channels > 1 && array.strides(2) != item) return false;
  if (array.shape(1) > 1 && array.strides(1) != channels * item) return false;
  // Rows that overlap or run backwards are copied.
  return array.shape(0) <= 1 ||
         (array.strides(0) >= array.shape(1) * channels * item && array.strides(0) % item == 0);
}

void keep_for_call(py::handle object) {
  py::detail::loader_life_support::add_patient(object);
}

py::object frozen(py::object value) {
  if (py::isinstance<py::array>(value)) {
    value.attr("setflags")(py::arg("write") = false);
    return value;
  }
  if (py::isinstance<py::list>(value)) {
    const auto list = py::reinterpret_borrow<py::list>(value);
    py::tuple tuple(list.size());
    for (std::size_t i = 0; i < list.size(); ++i) tuple[i] = frozen(list[i]);
    return std::move(tuple);
  }
  if (py::isinstance<py::dict>(value)) return py::reinterpret_steal<py::object>(PyDictProxy_New(value.ptr()));
  return value;
}

Triangles Loader<Triangles>::from(py::handle object, const Where& where) {
  const std::string expected = "int32 array of shape (n, 3)";
  const auto given = py::array::ensure(object);
  if (!given) refuse_type(where, expected, object);
  if (given.size() == 0) return {};
  if (given.dtype().kind() != 'i' && given.dtype().kind() != 'u') refuse_type(where, expected, given);
  if (given.ndim() != 2 || given.shape(1) != 3) refuse_shape(where, expected, given);
  const py::array_t<int, py::array::c_style | py::array::forcecast> array(given);
  Triangles triangles(std::size_t(array.shape(0)));
  std::copy(array.data(), array.data() + array.size(), triangles.front().data());
  return triangles;
}

std::vector<char> Loader<std::vector<char>>::from(py::handle object, const Where& where) {
  const std::string expected = "bool array of shape (n,)";
  const auto given = py::array::ensure(object);
  if (!given) refuse_type(where, expected, object);
  if (given.size() == 0) return {};
  if (given.dtype().kind() != 'b') refuse_type(where, expected, given);
  if (given.ndim() != 1) refuse_shape(where, expected, given);
  const py::array_t<bool, py::array::c_style | py::array::forcecast> array(given);
  return {array.data(), array.data() + array.size()};
}

}  // namespace procam::python
