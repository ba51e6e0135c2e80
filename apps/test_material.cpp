// `matpoint test-material`: one point of a material on a path, as a table.
#include "material/point_test.hpp"

#include <algorithm>

#include "case/case_file.hpp"
#include "commands.hpp"
#include "core/error.hpp"
#include "io/history.hpp"
#include "io/output_file.hpp"
#include "material/parameter_sets.hpp"

namespace matpoint {
namespace {

/// The law of that name with its parameters from --set, or the material of a body of a case.
std::shared_ptr<const Material> material_of(const TestMaterialOptions& options) {
  const std::vector<std::string> laws = material_registry().names();
  if (std::find(laws.begin(), laws.end(), options.what) != laws.end()) {
    if (!options.body.empty()) throw InputError("--body is for a case, and \"{}\" is a law", options.what);
    Input table = Input::table();
    table.set("type", Input::string(options.what));
    for (const std::string& set : options.sets) apply_set(table, set);
    return material_registry().read(table, {3, ""}, "material");
  }
  for (const ParameterSet& set : parameter_sets()) {
    if (set.name != options.what) continue;
    if (!options.body.empty()) throw InputError("--body is for a case, and \"{}\" is a parameter set", options.what);
    Input table = set.table;
    for (const std::string& change : options.sets) apply_set(table, change);
    return material_registry().read(table, {3, ""}, "material");
  }
  const Case problem = load_case(options.what, options.sets);
  if (options.body.empty()) return problem.bodies.front().material;
  std::vector<std::string> names;
  for (const BodySpec& body : problem.bodies) {
    if (body.name == options.body) return body.material;
    names.push_back(body.name);
  }
  throw InputError("--body = \"{}\" is unknown, the case has {}{}", printable(options.body), list_names(names),
                   did_you_mean(options.body, names));
}

}  // namespace

int test_material_command(const TestMaterialOptions& options) {
  Input asked = Input::table();
  for (const std::string& set : options.test) apply_set(asked, set);
  PointTestSpec spec;
  parameters_of<PointTestSpec>().read(asked, {3, "test-material"}, spec);
  const PointTestResult result = run_point_test(material_of(options), spec);
  std::vector<HistoryColumn> columns;
  for (std::size_t k = 0; k < result.names.size(); ++k) columns.push_back({result.names[k], result.units[k]});
  std::string text = header_line(columns);
  for (const std::vector<Real>& row : result.rows) text += csv_row(row);
  if (options.out.empty()) {
    say("{}", text);
    settle_standard_output();
  } else {
    write_file(options.out, text);
    say("{} rows in {}\n", result.rows.size(), options.out);
    if (options.out.ends_with(".csv")) say("next:    {} plot {}\n", shell_word(options.program), shell_word(options.out));
  }
  return k_exit_done;
}

}  // namespace matpoint
