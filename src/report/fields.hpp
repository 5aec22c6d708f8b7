#pragma once
/// One list of fields a result, for `--json` and for the data inside a page:
///
///   void fields(Fields& f, const analyze::Cause& cause) {
///     f.field("name", cause.name);
///     f.field("rms_mm", cause.rms_mm);
///   }
///
///   json(cause)   // {"name": "delay", "rms_mm": 3.1}
///
/// Names end in their unit where that is not metre or second. Numbers that are not finite become null.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "procam/core/base/types.hpp"
#include "procam/core/base/words.hpp"

namespace procam::report {

using Json = nlohmann::ordered_json;

class Fields {
 public:
  explicit Fields(Json& object) : object_(object) {
    if (object_.is_null()) object_ = Json::object();
  }

  template <typename T>
  void field(const std::string& name, const T& value);
  /// Absent when there is no value.
  template <typename T>
  void optional(const std::string& name, const std::optional<T>& value) {
    if (value) field(name, *value);
  }
  void optional(const std::string& name, const std::string& text) {
    if (!text.empty()) field(name, text);
  }
  /// An object in this one, whose fields `write` lists; one that is there already gets more of them.
  template <typename Write>
  void object(const std::string& name, const Write& write) {
    Fields inner(object_[name]);
    write(inner);
  }

 private:
  Json& object_;
};

template <typename T>
struct IsList : std::false_type {};
template <typename T>
struct IsList<std::vector<T>> : std::true_type {};

template <typename T>
Json json(const T& value) {
  if constexpr (std::is_arithmetic_v<T> || std::is_convertible_v<T, std::string>) {
    return Json(value);
  } else if constexpr (IsList<T>::value) {
    Json list = Json::array();
    for (const auto& item : value) list.push_back(json(item));
    return list;
  } else if constexpr (std::is_base_of_v<Eigen::MatrixBase<T>, T>) {
    Json list = Json::array();
    for (Eigen::Index i = 0; i < value.size(); ++i) list.push_back(value[i]);
    return list;
  } else {
    Json object = Json::object();
    Fields f(object);
    fields(f, value);
    return object;
  }
}

template <typename T>
void Fields::field(const std::string& name, const T& value) {
  object_[name] = json(value);
}

/// Indented by two spaces; bytes that are no UTF-8 (of file names) are replaced.
inline std::string text(const Json& value) {
  return value.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace procam::report
