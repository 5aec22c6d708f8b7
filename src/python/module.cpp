// The extension module procam._procam, which fills the package procam and its submodules.
#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

void check_signals() {
  const py::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void require_pixel(ImageSize size, int x, int y, const char* function) {
  if (x < 0 || y < 0 || x >= size.width || y >= size.height)
    throw std::invalid_argument(std::string(function) + ": (" + std::to_string(x) + ", " + std::to_string(y) +
                                ") is outside of " + std::to_string(size.width) + " x " +
                                std::to_string(size.height));
}

namespace {

/// The text of one field, short enough for a line.
std::string short_text(const py::object& value) {
  if (py::isinstance<py::array>(value)) {
    const auto array = py::reinterpret_borrow<py::array>(value);
    if (array.size() > 9) return "<" + description(array) + ">";
    return py::str(array.attr("tolist")()).cast<std::string>();
  }
  if (py::isinstance<py::tuple>(value) && py::len(value) > 4)
    return "<" + std::to_string(py::len(value)) + " items>";
  return py::repr(value).cast<std::string>();
}

}  // namespace

std::string with_shape(const char* doc, const char* type) {
  const std::string text = type, array = "numpy.ndarray[";
  const std::size_t at = text.find(array);
  if (at == std::string::npos) return doc;
  // "numpy.float64[n, 2]", "numpy.float64[3, 1]", "numpy.uint8[h, w, c]", "bool[n]"
  const std::size_t begin = at + array.size(), bracket = text.find('[', begin);
  std::string element = text.substr(begin, bracket - begin);
  if (element.rfind("numpy.", 0) == 0) element.erase(0, 6);
  std::string shape = text.substr(bracket + 1, text.find(']', bracket) - bracket - 1);
  if (shape.size() > 3 && shape.compare(shape.size() - 3, 3, ", 1") == 0) shape.erase(shape.size() - 2);
  if (shape == "h, w, c")
    shape = "h, w) or (h, w, c";
  else if (shape.find(',') == std::string::npos)
    shape += ",";
  const std::string whole = element + " (" + shape + ")";
  return *doc == 0 ? whole : doc + ("; " + whole);
}

std::string type_text(const char* text, const std::type_info* const* types) {
  std::string out;
  for (; *text != 0; ++text) {
    if (*text == '{' || *text == '}') continue;
    if (*text != '%') {
      out += *text;
      continue;
    }
    const std::type_info* const type = *types++;
    const auto* const known = py::detail::get_type_info(std::type_index(*type));
    std::string name;
    if (known != nullptr) {
      name = py::handle(reinterpret_cast<PyObject*>(known->type)).attr("__qualname__").cast<std::string>();
    } else {
      name = type->name();
      py::detail::clean_type_id(name);
    }
    out += name;
  }
  return out;
}

namespace {

/// A field as an argument again.
py::object as_argument(py::object value) {
  return Py_TYPE(value.ptr()) == &PyDictProxy_Type ? py::object(py::dict(value)) : value;
}

bool are_equal(const py::object& a, const py::object& b) {
  if (py::isinstance<py::array>(a) && py::isinstance<py::array>(b))
    return py::module_::import("numpy").attr("array_equal")(a, b).cast<bool>();
  if (py::isinstance<py::tuple>(a) && py::isinstance<py::tuple>(b)) {
    const auto left = py::reinterpret_borrow<py::tuple>(a), right = py::reinterpret_borrow<py::tuple>(b);
    if (left.size() != right.size()) return false;
    for (std::size_t i = 0; i < left.size(); ++i)
      if (!are_equal(left[i], right[i])) return false;
    return true;
  }
  return a.equal(b);
}

}  // namespace

namespace {

std::string record_text(py::handle self, const std::vector<std::string>& fields) {
  std::string text = self.get_type().attr("__name__").cast<std::string>() + "(";
  for (const std::string& field : fields) {
    if (text.back() != '(') text += ", ";
    text += field + "=" + short_text(self.attr(field.c_str()));
  }
  return text + ")";
}

/// For pickle: the type, and the fields that it is made with.
py::tuple record_parts(py::handle self, const std::vector<std::string>& fields) {
  py::list values;
  for (const std::string& field : fields) values.append(as_argument(self.attr(field.c_str())));
  return py::make_tuple(self.get_type(), py::tuple(values));
}

/// Are both of one type, with equal fields?
bool are_equal_records(py::handle self, py::handle other, const std::vector<std::string>& fields) {
  if (!self.get_type().is(other.get_type())) return false;
  for (const std::string& field : fields)
    if (!are_equal(as_argument(self.attr(field.c_str())), as_argument(other.attr(field.c_str()))))
      return false;
  return true;
}

/// As class_::def() does.
template <typename F>
void add_method(py::handle type, const char* name, F f) {
  py::object owner = py::reinterpret_borrow<py::object>(type);
  py::detail::add_class_method(owner, name,
                               py::cpp_function(std::move(f), py::name(name), py::is_method(type),
                                                py::sibling(py::getattr(type, name, py::none()))));
}

}  // namespace

void add_repr(py::handle type, NamesOfFields fields) {
  add_method(type, "__repr__", [fields](py::handle self) { return record_text(self, fields()); });
}

void add_copies(py::handle type, py::object (*copy)(py::handle self)) {
  add_method(type, "__copy__", copy);
  add_method(type, "__deepcopy__", [copy](py::handle self, const py::dict& /*memo*/) { return copy(self); });
}

void add_value_methods(py::handle type, NamesOfFields fields) {
  add_method(type, "__reduce__", [fields](py::handle self) { return record_parts(self, fields()); });
  add_method(type, "__eq__", [fields](py::handle self, py::handle other) {
    return are_equal_records(self, other, fields());
  });
}

py::cpp_function setter(std::function<void(py::handle self, py::handle value)> set) {
  return [set = std::move(set)](py::handle self, py::handle value) { set(self, value); };
}

void set_fields(py::handle self, const std::vector<std::string>& names, const py::args& values,
                const py::kwargs& named) {
  const std::string type = self.get_type().attr("__name__").cast<std::string>();
  if (values.size() > names.size())
    throw py::type_error(type + ": expected at most " + std::to_string(names.size()) + " fields, found " +
                         std::to_string(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) py::setattr(self, names[i].c_str(), values[i]);
  for (const auto& [key, value] : named) {
    const std::string name = py::str(key);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      std::string known;
      for (const std::string& one : names) known += (known.empty() ? "" : ", ") + one;
      throw py::type_error(type + ": no field '" + name + "'; its fields are " + known);
    }
    if (std::size_t(found - names.begin()) < values.size())
      throw py::type_error(type + ": field '" + name + "' is given twice");
    py::setattr(self, key, value);
  }
}

namespace {

constexpr const char* kErrorDoc =
    "An error that a person must act on: a file, too few views, a degenerate layout.\n\n"
    "kind: ErrorKind\nsubject, what_failed: the thing that failed, with its file, line, view or field\n"
    "why, cause: why it failed\nnext, next_step: what the person can do about it";

PyObject* error_type = nullptr;

/// Names of files need not be UTF-8.
py::str readable(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), Py_ssize_t(text.size()), "backslashreplace"));
}

void set_error(const Error& error) {
  py::object made = py::reinterpret_borrow<py::object>(error_type)(readable(error.what()));
  made.attr("kind") = error.kind();
  for (const char* name : {"subject", "what_failed"}) made.attr(name) = readable(error.subject());
  for (const char* name : {"why", "cause"}) made.attr(name) = readable(error.why());
  for (const char* name : {"next", "next_step"}) made.attr(name) = readable(error.next());
  PyErr_SetObject(error_type, made.ptr());
}

void bind_error(py::module_& package) {
  error_type = PyErr_NewExceptionWithDoc("procam.Error", kErrorDoc, PyExc_RuntimeError, nullptr);
  package.attr("Error") = py::handle(error_type);
  // By value: the type that pybind11 calls.
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& error) {
      set_error(error);
    }
  });
}

py::module_ submodule(const py::module_& package, const std::string& name, const char* doc) {
  const std::string full = package.attr("__name__").cast<std::string>() + "." + name;
  auto module = py::reinterpret_borrow<py::module_>(PyImport_AddModule(full.c_str()));
  module.doc() = doc;
  package.attr(name.c_str()) = module;
  return module;
}

}  // namespace

PYBIND11_MODULE(_procam, module) {
  module.doc() = "What procam is made of; import procam instead.";
  auto package = py::reinterpret_borrow<py::module_>(PyImport_AddModule("procam"));

  bind_error(package);
  bind_core_base(package);
  bind_core_pose(package);
  bind_core_geometry(package);
  bind_core_lens(package);
  bind_core_board(package);
  bind_core_rig(package);
  bind_core_surface(package);
  py::module_ pattern = submodule(package, "pattern", "Patterns that projectors show, and their decoding.");
  bind_pattern(pattern);
  py::module_ io = submodule(package, "io", "File formats.");
  bind_io(io);
  bind_io_exchange(io);
  py::module_ detect = submodule(package, "detect", "Boards and markers in images.");
  bind_detect(detect);
  py::module_ surface = submodule(package, "surface", "Surfaces to placements, blending and warps.");
  bind_surface(surface);
  py::module_ calibrate = submodule(package, "calibrate", "Correspondences to a rig.");
  bind_calibrate_bundle(calibrate);
  bind_calibrate(calibrate);
  py::module_ render = submodule(package, "render", "Placements to frames.");
  bind_render(render);
  py::module_ track = submodule(package, "track", "Poses over time, and from markers.");
  bind_track(track);
  bind_track_surfaces(track);
  py::module_ simulate =
      submodule(package, "simulate", "Simulated captures, rooms and robots, with their truth.");
  bind_simulate(simulate);
  bind_simulate_room(simulate);
  bind_simulate_live(simulate);
  bind_simulate_robot(simulate);
  py::module_ session = submodule(package, "session", "Folders of captures.");
  bind_session_views(session);
  bind_session(session);
  py::module_ scan = submodule(package, "scan", "The shape of a room, from structured light.");
  bind_scan(scan);
  py::module_ room = submodule(package, "room", "A rig without a board, from structured light on a room.");
  bind_room(room);
  py::module_ depth = submodule(package, "depth", "Planes in depth images.");
  bind_depth(depth);
  bind_depth_heights(depth);
  py::module_ analyze =
      submodule(package, "analyze", "The error in millimetres: predicted, drawn, measured.");
  bind_analyze(analyze);
  bind_analyze_projection(analyze);
  py::module_ report = submodule(package, "report", "Results as JSON, lines and pages.");
  bind_report(report);
  py::module_ show = submodule(package, "show", "Content on surfaces, live.");
  bind_show(show);
  bind_show_frames(show);
  py::module_ people = submodule(package, "people", "Skeletons over time, and light kept off people.");
  bind_people(people);
  py::module_ watch = submodule(package, "watch", "Where the light of a running show is, by a camera.");
  bind_watch(watch);
  bind_mount(package);
  bind_update(package);
}

}  // namespace procam::python
