#pragma once
/// How a component is bound: Record for structs and classes, Enum, function.
///
/// Names are those of C++; a name that Python keeps for itself ends in "_" (from_). A struct is made with its fields by
/// position or by name, and prints itself. What a field gives depends on its type:
///
///   a struct or a vector of fixed size   the field itself: what is changed in it is changed in the struct
///   a list, map, optional, variant, image   a copy, which cannot be changed: assign a new value to the field
#include <string>
#include <tuple>
#include <type_traits>

#include "convert.hpp"
#include "procam/core/base/error.hpp"

namespace procam::python {

/// Throws KeyboardInterrupt (and whatever another signal's handler raises) in Python's main thread.
void check_signals();

/// Throws std::invalid_argument, "DecodedMap.decoded: ...", for a place outside of [0, width) x [0, height): accessors of the
/// library do not look.
void require_pixel(ImageSize size, int x, int y, const char* function);

/// Calls of progress look for Ctrl-C before they call the caller's own.
template <typename... A>
std::function<void(A...)> interruptible(const std::function<void(A...)>& progress) {
  return [progress](A... a) {
    check_signals();
    if (progress) progress(a...);
  };
}

template <typename A>
using Plain = std::remove_cv_t<std::remove_reference_t<A>>;
template <typename A>
using Passed = std::conditional_t<IsArray<Plain<A>>::value, Arg<Plain<A>>, A>;

/// An argument for the time of a call.
template <typename A, typename = void>
struct Slot {
  A value;
  Slot(A passed, const Where&) : value(static_cast<A&&>(passed)) {}
};
template <typename A>
struct Slot<A, std::enable_if_t<IsArray<Plain<A>>::value>> {
  Plain<A> value;
  Slot(Arg<Plain<A>> passed, const Where& where) : value(Loader<Plain<A>>::from(passed.object, where)) {}
};
using StepProgress = std::function<void(const std::string&, int, int)>;
template <typename A>
struct Slot<A, std::enable_if_t<std::is_same_v<Plain<A>, StepProgress>>> {
  StepProgress value;
  Slot(const StepProgress& passed, const Where&) : value(interruptible(passed)) {}
};

template <typename F>
struct Signature : Signature<decltype(&F::operator())> {};
template <typename R, typename... A>
struct Signature<R (*)(A...)> {
  using Result = R;
  using Arguments = std::tuple<A...>;
};
template <typename R, typename C, typename... A>
struct Signature<R (C::*)(A...) const> : Signature<R (*)(A...)> {};
template <typename R, typename C, typename... A>
struct Signature<R (C::*)(A...)> : Signature<R (*)(A...)> {};

enum class Gil { kHeld, kReleased };

template <typename Arguments>
struct Caller;
template <typename... A>
struct Caller<std::tuple<A...>> {
  /// What pybind11 binds: takes arrays as they come and converts them where their names are known.
  template <typename R, typename F>
  static auto make(F f, const char* function, std::array<const char*, sizeof...(A)> names, Gil gil) {
    return [=](Passed<A>... passed) -> R {
      return call<R>(f, function, names, gil, std::index_sequence_for<A...>(),
                     static_cast<Passed<A>&&>(passed)...);
    };
  }

 private:
  template <typename R, typename F, std::size_t... I>
  static R call(const F& f, [[maybe_unused]] const char* function,
                [[maybe_unused]] const std::array<const char*, sizeof...(A)>& names, Gil gil,
                std::index_sequence<I...>, Passed<A>... passed) {
    [[maybe_unused]] std::tuple<Slot<A>...> slots{
        Slot<A>(static_cast<Passed<A>&&>(passed), Where{function, names[I]})...};
    std::optional<py::gil_scoped_release> released;
    if (gil == Gil::kReleased) released.emplace();
    return f(static_cast<A&&>(std::get<I>(slots).value)...);
  }
};

inline const char* argument_name(const py::arg& arg) {
  return arg.name;
}

/// A function of a module, by pointer or lambda. `extra` has py::arg or py::arg_v for each argument.
template <typename F, typename... Extra>
void function(py::module_& module, Gil gil, const char* name, F f, const char* doc, const Extra&... extra) {
  using S = Signature<F>;
  module.def(name,
             Caller<typename S::Arguments>::template make<typename S::Result>(f, name,
                                                                              {argument_name(extra)...}, gil),
             doc, py::return_value_policy::copy, extra...);
}
/// Works for long or waits: other threads of Python run meanwhile.
template <typename F, typename... Extra>
void function(py::module_& module, const char* name, F f, const char* doc, const Extra&... extra) {
  function(module, Gil::kReleased, name, f, doc, extra...);
}

template <typename T>
struct FieldNames {
  static std::vector<std::string>& all() {
    static std::vector<std::string> names;
    return names;
  }
};

/// A field's docstring with the type and shape of its array, if it is one: `type` as in signatures.
std::string with_shape(const char* doc, const char* type);

/// A type of signatures, with the names that Python has for types of procam: `text` and `types` of a caster's name.
std::string type_text(const char* text, const std::type_info* const* types);

/// Refuses what a field of type F cannot hold.
template <typename F>
[[noreturn]] void refuse_value(const Where& where, py::handle value) {
  if (std::is_integral_v<F> && PyLong_Check(value.ptr()))
    throw py::value_error(where.text() + ": " + py::str(value).cast<std::string>() + " is out of range");
  const auto types = decltype(py::detail::make_caster<F>::name)::types();
  refuse_type(where, type_text(py::detail::make_caster<F>::name.text, types.data()), value);
}

/// What does not depend on a record's type is bound by these: pybind11's templates are compiled once, not for each record and field.
using NamesOfFields = std::vector<std::string> (*)();
void add_repr(py::handle type, NamesOfFields fields);
void add_copies(py::handle type, py::object (*copy)(py::handle self));
/// Compared by its fields, and pickled: it is made with its fields, by position.
void add_value_methods(py::handle type, NamesOfFields fields);
py::cpp_function setter(std::function<void(py::handle self, py::handle value)> set);
void set_fields(py::handle self, const std::vector<std::string>& names, const py::args& values,
                const py::kwargs& named);

/// The fields that are part of the struct itself.
template <typename F>
constexpr bool kIsPart =
    std::is_base_of_v<py::detail::type_caster_generic, py::detail::make_caster<F>> && !std::is_enum_v<F>;
template <typename F>
struct IsFixedArray : std::false_type {};
template <int R, int C, int O>
struct IsFixedArray<Eigen::Matrix<double, R, C, O>>
    : std::bool_constant<R != Eigen::Dynamic && C != Eigen::Dynamic> {};

template <typename F>
F loaded(py::handle value, const Where& where) {
  if constexpr (IsArray<F>::value) {
    return Loader<F>::from(value, where);
  } else {
    py::detail::make_caster<F> caster;
    py::object given = py::reinterpret_borrow<py::object>(value);
    // What another record's map gives.
    if (Py_TYPE(value.ptr()) == &PyDictProxy_Type) given = py::dict(given);
    if (!caster.load(given, true)) refuse_value<F>(where, value);
    return py::detail::cast_op<F>(std::move(caster));
  }
}

/// A field's copy for Python, with the field's type in the signature.
template <typename F>
struct Frozen {
  py::object value;
};

template <typename T, typename... Options>
class Record {
 public:
  py::class_<T, Options...> type;

  Record(py::handle scope, const char* name, const char* doc) : type(scope, name, doc), name_(name) {
    add_repr(type, &fields);
    if constexpr (py::detail::is_copy_constructible<T>::value && !std::is_abstract_v<T>) {
      add_copies(type, [](py::handle self) { return py::cast(T(self.cast<const T&>())); });
    }
  }

  /// Made with its fields, by position or by name.
  Record& fields_init() {
    type.def(py::init([](const py::args& values, const py::kwargs& named) {
      auto made = std::make_unique<T>();
      const py::object self = py::cast(made.get(), py::return_value_policy::reference);
      set_fields(self, fields(), values, named);
      return made;
    }));
    return value_like();
  }

  Record& value_like() {
    add_value_methods(type, &fields);
    return *this;
  }

  template <typename C, typename F>
  Record& field(const char* name, F C::*member, const char* text) {
    FieldNames<T>::all().push_back(name);
    const std::string described = with_shape(text, py::detail::make_caster<F>::name.text);
    const char* const doc = described.c_str();
    const char* const record = name_;
    const py::cpp_function set = setter([member, record, name](py::handle self, py::handle value) {
      self.cast<T&>().*member = loaded<F>(value, {record, name});
    });
    if constexpr (kIsPart<F> || IsFixedArray<F>::value) {
      type.def_property(
          name, [member](T& self) -> F& { return self.*member; }, set,
          py::return_value_policy::reference_internal, doc);
    } else if constexpr (std::is_arithmetic_v<F> || std::is_enum_v<F> || std::is_same_v<F, std::string>) {
      type.def_property(
          name, [member](const T& self) { return self.*member; }, set, doc);
    } else {
      const auto get = [member](const T& self) {
        return Frozen<F>{py::cast(self.*member, py::return_value_policy::copy)};
      };
      type.def_property(name, get, set, doc);
    }
    return *this;
  }
  /// Read only.
  template <typename C, typename F>
  Record& constant(const char* name, F C::*member, const char* doc) {
    FieldNames<T>::all().push_back(name);
    type.def_property_readonly(
        name, [member](const T& self) { return self.*member; }, doc);
    return *this;
  }

  template <typename R, typename C, typename... A, typename... Extra>
  Record& method(const char* name, R (C::*f)(A...) const, const char* doc, const Extra&... extra) {
    return method(
        name, [f](const T& self, A... a) -> R { return (self.*f)(static_cast<A&&>(a)...); }, doc, extra...);
  }
  template <typename R, typename C, typename... A, typename... Extra>
  Record& method(const char* name, R (C::*f)(A...), const char* doc, const Extra&... extra) {
    return method(
        name, [f](T& self, A... a) -> R { return (self.*f)(static_cast<A&&>(a)...); }, doc, extra...);
  }
  /// A lambda that takes the object first. Holds the GIL.
  template <typename F, typename... Extra>
  Record& method(const char* name, F f, const char* doc, const Extra&... extra) {
    using S = Signature<F>;
    type.def(name,
             Caller<typename S::Arguments>::template make<typename S::Result>(
                 f, name, {"self", argument_name(extra)...}, Gil::kHeld),
             doc, py::return_value_policy::copy, extra...);
    return *this;
  }
  template <typename F, typename... Extra>
  Record& static_method(const char* name, F f, const char* doc, const Extra&... extra) {
    using S = Signature<F>;
    type.def_static(name,
                    Caller<typename S::Arguments>::template make<typename S::Result>(
                        f, name, {argument_name(extra)...}, Gil::kHeld),
                    doc, py::return_value_policy::copy, extra...);
    return *this;
  }
  /// A constructor, as a lambda that returns the object.
  template <typename F, typename... Extra>
  Record& init(F f, const char* doc, const Extra&... extra) {
    using S = Signature<F>;
    type.def(py::init(Caller<typename S::Arguments>::template make<typename S::Result>(
                 f, name_, {argument_name(extra)...}, Gil::kHeld)),
             doc, extra...);
    return *this;
  }

 private:
  /// Those of the base come first, as in an aggregate.
  static std::vector<std::string> fields() {
    std::vector<std::string> names;
    [[maybe_unused]] const auto add = [&](const std::vector<std::string>& more) {
      names.insert(names.end(), more.begin(), more.end());
    };
    (add(std::is_base_of_v<Options, T> ? FieldNames<Options>::all() : std::vector<std::string>()), ...);
    add(FieldNames<T>::all());
    return names;
  }

  const char* name_;
};

template <typename E>
class Enum {
 public:
  Enum(py::handle scope, const char* name, const char* doc) : type_(scope, name, doc) {}
  Enum& value(const char* name, E value, const char* doc = nullptr) {
    type_.value(name, value, doc);
    return *this;
  }

 private:
  py::enum_<E> type_;
};

}  // namespace procam::python

namespace pybind11::detail {

template <typename F>
struct type_caster<procam::python::Frozen<F>> {
  PYBIND11_TYPE_CASTER(procam::python::Frozen<F>, make_caster<F>::name);
  bool load(handle, bool) { return false; }
  static handle cast(const procam::python::Frozen<F>& frozen, return_value_policy, handle) {
    return procam::python::frozen(frozen.value).release();
  }
};

}  // namespace pybind11::detail
