// matpoint._core: the core as it is, without defaults and without comfort. The package around it is what users see.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <filesystem>

#include "case/case.hpp"
#include "case/case_file.hpp"
#include "convert.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/version.hpp"
#include "functions.hpp"
#include "kernel/kernel.hpp"
#include "material/parameter_sets.hpp"
#include "material/point_test.hpp"
#include "simulation.hpp"

namespace matpoint::python {
namespace {

nb::list describe(const std::vector<ParameterDescription>& parameters) {
  nb::list list;
  for (const ParameterDescription& p : parameters) {
    nb::dict entry;
    entry["name"] = p.name;
    entry["unit"] = p.unit;
    entry["type"] = p.type;
    entry["default"] = p.default_text;
    entry["allowed"] = p.allowed;
    entry["help"] = p.help;
    entry["is_required"] = p.is_required;
    list.append(entry);
  }
  return list;
}

nb::dict describe(const std::string& name, const std::string& summary, const std::vector<ParameterDescription>& parameters) {
  nb::dict entry;
  entry["name"] = name;
  entry["summary"] = summary;
  entry["parameters"] = describe(parameters);
  return entry;
}

template <class Base>
nb::list describe(const TypeRegistry<Base>& registry) {
  nb::list list;
  for (const auto& entry : registry.entries()) list.append(describe(entry.name, entry.summary, entry.parameters));
  return list;
}

/// Everything that a case can name, with its parameters.
nb::typed<nb::dict, nb::str, nb::typed<nb::list, Table>> vocabulary() {
  nb::typed<nb::dict, nb::str, nb::typed<nb::list, Table>> all;
  nb::list sections;
  for (const CaseSection& section : case_sections()) sections.append(describe(section.name, section.summary, section.parameters));
  all["sections"] = sections;
  all["regions"] = describe(region_registry());
  all["layouts"] = describe(layout_registry());
  all["velocities"] = describe(velocity_registry());
  all["initial_stresses"] = describe(initial_stress_registry());
  all["materials"] = describe(material_registry());
  all["rules"] = describe(step_rule_registry());
  return all;
}

/// A case file or a shipped case, with changes, checked as far as it can be without particles: (name, data).
nb::typed<nb::tuple, nb::str, Table> load_case_data(const std::string& name, const std::vector<std::string>& sets) {
  const CaseText found = find_case(name);
  Input input = parse_toml(found.text, found.file);
  for (const std::string& set : sets) apply_set(input, set);
  Case::from_input(input, found.name);
  return nb::borrow<nb::typed<nb::tuple, nb::str, Table>>(nb::make_tuple(found.name, from_input(input)));
}

}  // namespace
}  // namespace matpoint::python

NB_MODULE(_core, m) {
  using namespace matpoint;
  using namespace matpoint::python;
  // What lives until the interpreter ends, e.g. a simulation in a script's globals, is no leak.
  nb::set_leak_warnings(false);
  nb::exception<InputError>(m, "InputError", PyExc_ValueError);
  nb::exception<SolverError>(m, "SolverError", PyExc_RuntimeError);
  // A path that the system does not take, e.g. since it is too long.
  nb::register_exception_translator(
      [](const std::exception_ptr& error, void* input_error) {
        try {
          std::rethrow_exception(error);
        } catch (const std::filesystem::filesystem_error& refused) {
          PyErr_SetString(static_cast<PyObject*>(input_error), refused.what());
        }
      },
      m.attr("InputError").ptr());
  bind_functions(m);
  bind_simulation(m);
  m.def("vocabulary", &vocabulary);
  m.def("load_case", &load_case_data, nb::arg("name"), nb::arg("sets"));
  m.def(
      "parse_toml", [](const std::string& text, const std::string& file) { return nb::borrow<Table>(from_input(parse_toml(text, file))); },
      nb::arg("text"), nb::arg("file"));
  m.def(
      "write_toml", [](nb::handle data) { return write_toml(to_input(data, "")); }, nb::arg("data"));
  m.def(
      "resolve",
      [](nb::handle data, const std::string& name) {
        return nb::borrow<Table>(from_input(Case::from_input(to_input(data, ""), name).to_input()));
      },
      nb::arg("data"), nb::arg("name"));
  m.def(
      "point_test",
      [](nb::handle material, nb::handle test) {
        const ReadContext context{3, ""};
        const Input table = material_table(to_input(material, "material"), context);
        const std::shared_ptr<Material> law = material_registry().read(table, context, "material");
        PointTestSpec spec;
        parameters_of<PointTestSpec>().read(to_input(test, "point_test"), {3, "point_test"}, spec);
        const PointTestResult result = run_point_test(law, spec);
        std::vector<Real> values;
        for (std::size_t c = 0; c < result.names.size(); ++c) {
          for (const std::vector<Real>& row : result.rows) values.push_back(row[c]);
        }
        return nb::make_tuple(result.names, result.units, make_array(std::move(values), {result.names.size(), result.rows.size()}));
      },
      nb::arg("material"), nb::arg("test"),
      nb::sig(
          "def point_test(material: object, test: dict[str, object]) -> tuple[list[str], list[str], numpy.typing.NDArray[numpy.float64]]"));
  m.def("shipped_cases", [] {
    std::vector<std::string> names;
    for (const auto& [name, text] : shipped_cases()) names.push_back(name);
    return names;
  });
  m.def("set_threads", &set_thread_count, nb::arg("count"));
  m.def("threads", &thread_count);
  m.def("version", [] { return std::string(version()); });
  m.def("instruction_set", &instruction_set);
}
