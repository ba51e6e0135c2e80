#include "convert.hpp"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include "case/case.hpp"
#include "core/error.hpp"
#include "geometry/layout.hpp"
#include "geometry/region.hpp"
#include "material/material.hpp"

namespace matpoint::python {
namespace {

template <class T>
bool take_object(nb::handle value, const char* text, Input& input) {
  std::shared_ptr<T> object;
  if (!nb::try_cast<std::shared_ptr<T>>(value, object, false) || object == nullptr) return false;
  input = Input::object<T>(std::move(object), text);
  return true;
}

/// How deep lists and tables may stand in each other: a list that holds itself has no end.
constexpr int k_depth_max = 100;

std::string text_from(nb::handle value, const std::string& where) {
  Py_ssize_t size = 0;
  const char* const text = PyUnicode_AsUTF8AndSize(value.ptr(), &size);
  if (text != nullptr) return {text, static_cast<std::size_t>(size)};
  PyErr_Clear();
  const nb::object shown = nb::steal(PyObject_ASCII(value.ptr()));
  throw InputError("{}: the text {} has a character that no file can hold (a lone surrogate)", where, nb::cast<std::string>(shown));
}

bool is_numpy_scalar(nb::handle value) { return nb::hasattr(value, "dtype") && nb::hasattr(value, "item"); }

}  // namespace

Input to_input(nb::handle value, const std::string& where, int depth) {
  if (depth > k_depth_max) throw InputError("{}: lists and dicts stand in each other more than {} deep", where.substr(0, 60), k_depth_max);
  if (PyBool_Check(value.ptr())) return Input::boolean(nb::cast<bool>(value));
  if (PyLong_Check(value.ptr())) {
    Index number = 0;
    if (!nb::try_cast<Index>(value, number)) throw InputError("{}: the integer {} has more than 64 bits", where, nb::str(value).c_str());
    return Input::integer(number);
  }
  if (PyFloat_Check(value.ptr())) return Input::real(nb::cast<Real>(value));
  if (PyUnicode_Check(value.ptr())) return Input::string(text_from(value, where));
  if (PyDict_Check(value.ptr())) {
    Input table = Input::table();
    for (auto [key, item] : nb::cast<nb::dict>(value)) {
      if (!PyUnicode_Check(key.ptr())) throw InputError("{}: the key {} must be a string", where, nb::repr(key).c_str());
      const std::string name = text_from(key, where.empty() ? "a key" : where);
      table.entries().emplace_back(name, to_input(item, where.empty() ? name : where + "." + name, depth + 1));
    }
    return table;
  }
  if (PyList_Check(value.ptr()) || PyTuple_Check(value.ptr())) {
    Input array = Input::array();
    std::size_t index = 0;
    for (nb::handle item : nb::iter(value)) array.items().push_back(to_input(item, fmt::format("{}[{}]", where, index++), depth + 1));
    return array;
  }
  Input object;
  if (take_object<Region>(value, "a region chosen by a function", object) || take_object<Layout>(value, "particles from arrays", object) ||
      take_object<Material>(value, "a law written as a function", object) ||
      take_object<VelocityHistory>(value, "a function of time", object) ||
      take_object<BodyForce>(value, "a function of position", object)) {
    return object;
  }
  if (nb::hasattr(value, "tolist") && is_numpy_scalar(value)) {
    const nb::object plain = value.attr("tolist")();
    if (!is_numpy_scalar(plain)) return to_input(plain, where, depth + 1);
    // Numbers that Python has not, such as long doubles, are what they are for NumPy also then.
    if (nb::cast<std::string>(plain.attr("dtype").attr("kind")) == "f") return Input::real(nb::cast<Real>(nb::float_(plain)));
  }
  throw InputError("{}: {} of type {} is no value of a case; allowed: numbers, texts, lists, dicts and the parts of matpoint", where,
                   printable(nb::repr(value).c_str(), 60), nb::str(nb::handle(value.type()).attr("__name__")).c_str());
}

nb::object from_input(const Input& input) {
  switch (input.kind()) {
    case Input::Kind::boolean: return nb::bool_(input.as_boolean());
    case Input::Kind::integer: return nb::int_(input.as_integer());
    case Input::Kind::real: return nb::float_(input.as_real());
    case Input::Kind::string: return nb::str(input.as_string().c_str(), input.as_string().size());
    case Input::Kind::object: return nb::str(input.text().c_str());
    case Input::Kind::array: {
      nb::list list;
      for (const Input& item : input.items()) list.append(from_input(item));
      return list;
    }
    case Input::Kind::table: break;
  }
  nb::dict dict;
  for (const auto& [key, item] : input.entries()) dict[nb::str(key.c_str(), key.size())] = from_input(item);
  return dict;
}

Array make_array(std::vector<Real> values, const std::vector<std::size_t>& shape) {
  auto* const owner = new std::vector<Real>(std::move(values));
  const nb::capsule capsule(owner, [](void* pointer) noexcept { delete static_cast<std::vector<Real>*>(pointer); });
  return Array(owner->data(), shape.size(), shape.data(), capsule);
}

Array make_array(Field field) {
  const auto n = static_cast<std::size_t>(field.count());
  if (field.components == 1) return make_array(std::move(field.values), {n});
  if (field.components == 9) return make_array(std::move(field.values), {n, 3, 3});
  if (field.components != 6) return make_array(std::move(field.values), {n, static_cast<std::size_t>(field.components)});
  std::vector<Real> tensors(9 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const Real* const s = field.values.data() + 6 * i;
    const std::array<Real, 9> full{s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]};
    std::copy(full.begin(), full.end(), tensors.begin() + static_cast<std::ptrdiff_t>(9 * i));
  }
  return make_array(std::move(tensors), {n, 3, 3});
}

}  // namespace matpoint::python
