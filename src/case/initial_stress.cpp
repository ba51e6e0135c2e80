#include "case/initial_stress.hpp"

#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "case/case.hpp"
#include "case/case_reading.hpp"

namespace matpoint {
namespace {

template <class Stress>
void declare_consolidation(ParameterTable<Stress>& table) {
  table.optional("overconsolidation", "1", static_cast<std::optional<Real> Stress::*>(&Stress::overconsolidation),
                 Constraint{"at least 1", [](Real x) { return x >= 1; }},
                 "For cam_clay: the preconsolidation pressure is this many times that of the start. Without it the material's holds.");
}

struct UniformStress final : InitialStress {
  static constexpr auto name = "uniform";
  static constexpr auto summary = "The same stress everywhere.";

  std::vector<Real> value;

  static void declare(ParameterTable<UniformStress>& table) {
    table.custom(
        {"value", "Pa", "4 numbers in 2D, 6 in 3D", "", "finite", "Cauchy stress, tension positive: xx yy zz xy, and yz xz in 3D.", true},
        [](UniformStress& stress, const Input& input, const ReadContext& context) {
          read_value(input, context, "value", any_number(), stress.value);
          const std::size_t count = context.dim == 2 ? 4 : 6;
          if (stress.value.size() != count) {
            fail_input(
                input, context,
                fmt::format("value has {} numbers; give {}: xx yy zz xy{}", stress.value.size(), count, context.dim == 2 ? "" : " yz xz"));
          }
        },
        [](const UniformStress& stress, int dim) -> std::optional<Input> { return write_value(stress.value, dim); });
    declare_consolidation(table);
  }
  std::array<Real, 6> at(const Vec3&) const override {
    std::array<Real, 6> all{};
    std::copy(value.begin(), value.end(), all.begin());
    return all;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

/// Under a horizontal surface: sigma_v = -(surcharge + weight above), sigma_h = K0 sigma_v. Layers are bodies one above the other.
struct GeostaticStress final : InitialStress {
  static constexpr auto name = "geostatic";
  static constexpr auto summary = "The weight of what lies above, under a horizontal surface, in layers; K0 times that across.";

  Real K0 = 0;
  std::optional<Real> surface;  ///< [m]
  Real surcharge = 0;           ///< [Pa]

  static void declare(ParameterTable<GeostaticStress>& table) {
    table.required("K0", "1", &GeostaticStress::K0, positive(),
                   "Horizontal over vertical stress; 1 - sin(phi) in sand at rest, 1 in a fluid.");
    table.optional("surface", "m", &GeostaticStress::surface, any_number(),
                   "Where the ground ends, along gravity's axis; default: the top of the highest body with such a stress.");
    table.optional("surcharge", "Pa", &GeostaticStress::surcharge, non_negative(), "Pressure on the surface.");
    declare_consolidation(table);
  }
  std::array<Real, 6> at(const Vec3& x) const override {
    const Real height = x[axis_] * up_;
    Real weight = surcharge;
    for (const Layer& layer : layers_) weight += layer.weight * std::max(Real{0}, layer.top - std::max(height, layer.bottom));
    std::array<Real, 6> stress{-K0 * weight, -K0 * weight, -K0 * weight, 0, 0, 0};
    stress[axis_] = -weight;
    return stress;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
  void resolve(const Case& problem, const BodySpec& body) override;

 private:
  /// Heights against gravity [m], and weight per volume [N/m^3].
  struct Layer {
    Real bottom, top, weight;
  };
  std::size_t axis_ = 1;
  Real up_ = 1;
  std::vector<Layer> layers_;
};

const std::vector<std::string>& stress_names(int dim) {
  static const std::vector<std::string> plane{"xx", "yy", "zz", "xy"}, full{"xx", "yy", "zz", "xy", "yz", "xz"};
  return dim == 2 ? plane : full;
}

/// Known at points, from another program or a survey: each particle takes that of the nearest one.
struct TableStress final : InitialStress {
  static constexpr auto name = "table";
  static constexpr auto summary = "Given at points, in the case or in a CSV file: each particle takes that of the nearest point.";

  std::vector<Vec3> positions;                ///< [m]
  std::vector<std::array<Real, 6>> stresses;  ///< [Pa]
  std::string file;                           ///< Where they came from.

  static void declare(ParameterTable<TableStress>& table) {
    table.custom(
        {"file", "1", "string", "", "a CSV file",
         "Instead of the next two: its columns x, y (and z), xx, yy, zz, xy (and yz, xz), in any order; beside the "
         "case file where the name is no whole path.",
         false},
        [](TableStress& stress, const Input& input, const ReadContext& context) {
          read_value(input, context, "file", any_number(), stress.file);
          stress.read_file(input, context);
        },
        // What was read goes with the case.
        [](const TableStress&, int) -> std::optional<Input> { return std::nullopt; });
    table.custom(
        {"positions", "m", "array of points", "", "with stresses", "Points, dim numbers each.", false},
        [](TableStress& stress, const Input& input, const ReadContext& context) {
          read_value(input, context, "positions", any_number(), stress.positions);
        },
        [](const TableStress& stress, int dim) -> std::optional<Input> { return write_value(stress.positions, dim); });
    table.custom(
        {"stresses", "Pa", "array of arrays", "", "one for each of positions",
         "Cauchy stress there, tension positive: xx yy zz xy, and yz xz in 3D.", false},
        [](TableStress& stress, const Input& input, const ReadContext& context) {
          if (input.kind() != Input::Kind::array) fail_input(input, context, "stresses must be an array of arrays of numbers");
          stress.stresses.clear();
          for (const Input& row : input.items()) {
            std::vector<Real> values;
            read_value(row, context, "stresses", any_number(), values);
            stress.add(row, context, values);
          }
        },
        [](const TableStress& stress, int dim) -> std::optional<Input> {
          Input rows = Input::array();
          for (const std::array<Real, 6>& one : stress.stresses)
            rows.items().push_back(write_value(std::vector<Real>(one.begin(), one.begin() + (dim == 2 ? 4 : 6)), dim));
          return rows;
        });
    declare_consolidation(table);
  }
  void check(const Input& input, const ReadContext& context) const override {
    if (is_given(input, "file") && (is_given(input, "positions") || is_given(input, "stresses")))
      fail_input(at_key(input, "file"), context, "file and positions with stresses are both given; give one of them");
    if (positions.empty())
      fail_input(input, context, "has no points: give file = \"...\", or positions = [[...], ...] with stresses = [[...], ...]");
    if (positions.size() != stresses.size())
      fail_input(at_key(input, "stresses"), context,
                 fmt::format("positions has {} entries and stresses {}; they must match", positions.size(), stresses.size()));
  }
  void resolve(const Case& problem, const BodySpec&) override {
    dim_ = static_cast<std::size_t>(problem.dim);
    order_.resize(positions.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return positions[a][0] < positions[b][0]; });
  }
  std::array<Real, 6> at(const Vec3& x) const override {
    // Outwards from x along the first direction, as long as what comes may be nearer.
    const auto from = std::partition_point(order_.begin(), order_.end(), [&](std::size_t k) { return positions[k][0] < x[0]; });
    std::size_t nearest = order_.front();
    Real least = std::numeric_limits<Real>::infinity();
    const auto look = [&](std::size_t k) {
      Real distance = 0;
      for (std::size_t d = 0; d < dim_; ++d) distance += (positions[k][d] - x[d]) * (positions[k][d] - x[d]);
      if (distance < least || (distance == least && k < nearest)) {
        least = distance;
        nearest = k;
      }
      return (positions[k][0] - x[0]) * (positions[k][0] - x[0]) <= least;
    };
    for (auto k = from; k != order_.end() && look(*k);) ++k;
    for (auto k = from; k != order_.begin() && look(*std::prev(k));) --k;
    return stresses[nearest];
  }
  Input write(int dim) const override { return write_typed(*this, dim); }

 private:
  // A case carries its table along, and has 16 MB at most.
  static constexpr std::size_t k_rows_max = 50'000;

  void add(const Input& input, const ReadContext& context, const std::vector<Real>& values) {
    const std::size_t count = stress_names(context.dim).size();
    if (values.size() != count)
      fail_input(input, context,
                 fmt::format("stresses: {} numbers; give {}: {}", values.size(), count, fmt::join(stress_names(context.dim), " ")));
    stresses.emplace_back();
    std::copy(values.begin(), values.end(), stresses.back().begin());
  }
  void read_file(const Input& input, const ReadContext& context);

  std::vector<std::size_t> order_;  ///< Of the points, by x.
  std::size_t dim_ = 2;
};

void TableStress::read_file(const Input& input, const ReadContext& context) {
  std::filesystem::path path = file;
  const std::string place = input.place();
  if (path.is_relative() && place.find(".toml:") != std::string::npos)
    path = std::filesystem::path(place.substr(0, place.rfind(':'))).parent_path() / path;
  std::error_code none;
  if (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none))
    fail_input(input, context, fmt::format("\"{}\" is no file", path.string()));
  // Rows are short, and there may be 50,000 of them; a line without an end would fill the memory.
  constexpr std::uintmax_t k_file_size_max = 64u << 20;
  if (const std::uintmax_t size = std::filesystem::file_size(path, none); !none && size > k_file_size_max)
    fail_input(input, context, fmt::format("\"{}\" has more than {} MB; thin the table out", path.string(), k_file_size_max >> 20));
  std::ifstream stream(path);
  if (!stream) fail_input(input, context, fmt::format("cannot read \"{}\": {}", path.string(), std::strerror(errno)));
  std::vector<std::string> wanted = axis_names(context.dim);
  wanted.insert(wanted.end(), stress_names(context.dim).begin(), stress_names(context.dim).end());
  const auto cells_of = [](std::string line) {
    std::vector<std::string> cells;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    for (std::size_t begin = 0; begin <= line.size();) {
      const std::size_t end = std::min(line.find(',', begin), line.size());
      const std::size_t first = std::min(line.find_first_not_of(" \t\"", begin), end);
      std::size_t last = end;
      while (last > first && std::strchr(" \t\"", line[last - 1]) != nullptr) --last;
      cells.push_back(line.substr(first, last - first));
      begin = end + 1;
    }
    return cells;
  };
  const auto fail = [&](int number, const std::string& text) {
    fail_input(input, context, fmt::format("{}:{}: {}", path.string(), number, text));
  };
  std::string line;
  std::getline(stream, line);
  if (line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // a mark of bytes' order, as spreadsheets write it
  const std::vector<std::string> head = cells_of(line);
  std::vector<std::size_t> columns;
  for (const std::string& column : wanted) {
    const auto found = std::find(head.begin(), head.end(), column);
    if (found == head.end()) {
      fail(1, fmt::format("has no column \"{}\"; its first line must name {}", printable(column), fmt::join(wanted, ", ")));
    }
    columns.push_back(static_cast<std::size_t>(found - head.begin()));
  }
  for (int number = 2; std::getline(stream, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() != head.size()) fail(number, fmt::format("has {} values; the first line names {}", cells.size(), head.size()));
    if (positions.size() == k_rows_max)
      fail(number, fmt::format("has more than {} rows; thin the table out, or set stresses particle by particle in Python (body.stress)",
                               k_rows_max));
    std::vector<Real> values;
    for (const std::size_t c : columns) {
      Real value = 0;
      const auto [end, error] = std::from_chars(cells[c].data(), cells[c].data() + cells[c].size(), value);
      if (error != std::errc{} || end != cells[c].data() + cells[c].size() || !std::isfinite(value))
        fail(number, fmt::format("{} = \"{}\" is not a finite number", head[c], printable(cells[c])));
      values.push_back(value);
    }
    const auto dim = static_cast<std::ptrdiff_t>(context.dim);
    Vec3 x{};
    std::copy(values.begin(), values.begin() + dim, x.begin());
    positions.push_back(x);
    add(input, context, {values.begin() + dim, values.end()});
  }
  if (positions.empty()) fail(1, "has no rows");
}

[[noreturn]] void fail_stress(const BodySpec& body, const std::string& text) {
  throw InputError("{}: initial_stress: {}", place_of(body), text);
}

void GeostaticStress::resolve(const Case& problem, const BodySpec& body) {
  int count = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    if (problem.gravity[d] == 0) continue;
    ++count;
    axis_ = d;
    up_ = problem.gravity[d] < 0 ? 1 : -1;
  }
  if (count != 1) {
    fail_stress(body,
                fmt::format("\"geostatic\" needs gravity along one axis, and the case has [{}]; take \"uniform\", or turn the geometry",
                            fmt::join(problem.gravity.begin(), problem.gravity.begin() + problem.dim, ", ")));
  }
  const Real g = std::abs(problem.gravity[axis_]);
  layers_.clear();
  Real highest = -std::numeric_limits<Real>::infinity();
  for (const BodySpec& other : problem.bodies) {
    if (dynamic_cast<const GeostaticStress*>(other.initial_stress.get()) == nullptr) continue;
    if (!other.region) fail_stress(other, "\"geostatic\" needs a region, from which the layer's top and bottom follow");
    const Real a = up_ * std::max(other.region->lower()[axis_], problem.grid.lower[axis_]);
    const Real b = up_ * std::min(other.region->upper()[axis_], problem.grid.upper[axis_]);
    layers_.push_back({std::min(a, b), std::max(a, b), g * other.material->density()});
    highest = std::max(highest, std::max(a, b));
  }
  std::sort(layers_.begin(), layers_.end(), [](const Layer& a, const Layer& b) { return a.bottom < b.bottom; });
  for (std::size_t i = 1; i < layers_.size(); ++i) {
    const Real apart = layers_[i].bottom - layers_[i - 1].top;
    if (std::abs(apart) <= 1e-6 * (layers_[i].top - layers_[i].bottom)) continue;
    fail_stress(body,
                fmt::format("\"geostatic\" is for layers one above the other; one ends at {:.6g} and the next begins at {:.6g}: bodies "
                            "side by side, or with a gap, need \"uniform\"",
                            up_ * layers_[i - 1].top, up_ * layers_[i].bottom));
  }
  if (!surface) return;
  const Real level = up_ * *surface;
  if (level < highest - 1e-9 * std::abs(highest)) {
    fail_stress(body, fmt::format("surface = {} is below the top of the bodies, {:.6g}", *surface, up_ * highest));
  }
  layers_.back().top = level;
}

}  // namespace

const TypeRegistry<InitialStress>& initial_stress_registry() {
  static const TypeRegistry<InitialStress> registry = [] {
    TypeRegistry<InitialStress> all;
    all.add<UniformStress>();
    all.add<GeostaticStress>();
    all.add<TableStress>();
    return all;
  }();
  return registry;
}

void resolve_initial_stresses(Case& problem) {
  for (BodySpec& body : problem.bodies) {
    if (!body.initial_stress) continue;
    const bool is_kept_by_F = !body.material->remembers_strain();
    if (is_kept_by_F && body.formulation == Formulation::total)
      fail_stress(body,
                  fmt::format("formulation = \"total\" measures F from the start, and \"{}\" keeps its stress in F; take formulation = "
                              "\"updated\", or a law that flows, as \"j2\"",
                              body.material->type()));
    if (is_kept_by_F && body.method == BodyMethod::elements)
      fail_stress(body, fmt::format("elements measure F from the start, and \"{}\" keeps its stress in F; take a law that flows, as \"j2\"",
                                    body.material->type()));
    if (body.initial_stress->overconsolidation && !body.material->consolidates())
      fail_stress(body, fmt::format("overconsolidation is for cam_clay, and the material is \"{}\"", body.material->type()));
    body.initial_stress->resolve(problem, body);
  }
}

}  // namespace matpoint
