#include "geometry/region.hpp"

#include <numbers>

#include "geometry/region_parts.hpp"

namespace matpoint {
using namespace region_parts;

namespace {

struct Box final : Region {
  static constexpr auto name = "box";
  static constexpr auto summary = "A box with sides along the axes; a rectangle in 2D.";

  Vec3 lower_corner{};
  Vec3 upper_corner{};

  static void declare(ParameterTable<Box>& table) {
    table.required("lower", "m", &Box::lower_corner, any_number(), "Corner with the smallest coordinates.");
    table.required("upper", "m", &Box::upper_corner, any_number(),
                   "Corner with the largest coordinates; each is greater than that of lower.");
  }
  bool contains(const Vec3& x) const override { return reaches(x, 0); }
  bool reaches(const Vec3& x, Real tolerance) const override {
    for (std::size_t d = 0; d < 3; ++d) {
      if (!(x[d] >= lower_corner[d] - tolerance && x[d] <= upper_corner[d] + tolerance)) return false;
    }
    return true;
  }
  Vec3 lower() const override { return lower_corner; }
  Vec3 upper() const override { return upper_corner; }
  std::optional<Real> measure(int dim) const override {
    Real product = 1;
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) product *= upper_corner[d] - lower_corner[d];
    return product;
  }
  bool has_normal() const override { return true; }
  std::vector<Vec3> normals(const Vec3& x, int dim) const override {
    std::vector<std::pair<Real, Vec3>> faces;
    Real size = 0;
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
      Vec3 normal{};
      normal[d] = 1;
      faces.emplace_back(upper_corner[d] - x[d], normal);
      normal[d] = -1;
      faces.emplace_back(x[d] - lower_corner[d], normal);
      size = std::max(size, upper_corner[d] - lower_corner[d]);
    }
    return nearest_normals(faces, size);
  }
  std::optional<NearSurface> surface_near(const Vec3& x, int dim) const override {
    // Outside: to the nearest point of the box; inside: to the nearest face.
    NearSurface near{-k_infinity, {}};
    Vec3 beyond{};
    bool is_outside = false;
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
      for (const bool is_upper : {false, true}) {
        const Real past = is_upper ? x[d] - upper_corner[d] : lower_corner[d] - x[d];
        if (past > 0) {
          beyond[d] = is_upper ? past : -past;
          is_outside = true;
        }
        if (past <= near.distance) continue;
        near.distance = past;
        near.normal = {};
        near.normal[d] = is_upper ? 1 : -1;
      }
    }
    if (!is_outside) return near;
    near.distance = std::hypot(beyond[0], beyond[1], beyond[2]);
    for (std::size_t d = 0; d < 3; ++d) near.normal[d] = beyond[d] / near.distance;
    return near;
  }
  std::optional<Solid> solid(int dim) const override {
    Solid solid{*measure(dim), {}, {}};
    Vec3 squares{};
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
      solid.center[d] = 0.5 * (lower_corner[d] + upper_corner[d]);
      squares[d] = std::pow(upper_corner[d] - lower_corner[d], 2) / 12;
    }
    for (std::size_t d = 0; d < 3; ++d) solid.inertia[4 * d] = solid.volume * (squares[(d + 1) % 3] + squares[(d + 2) % 3]);
    return solid;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
  void check(const Input& input, const ReadContext& context) const override {
    for (std::size_t d = 0; d < static_cast<std::size_t>(context.dim); ++d) {
      if (upper_corner[d] > lower_corner[d]) continue;
      fail_input(value_of(input, "upper"), context,
                 fmt::format("upper[{}] = {} must be greater than lower[{}] = {}", d, upper_corner[d], d, lower_corner[d]));
    }
    check_measure(*this, input, context);
  }
};

struct HalfSpace final : Region {
  static constexpr auto name = "half_space";
  static constexpr auto summary = "Everything behind a plane (a line in 2D): (x - point) . normal <= 0. Unbounded.";

  Vec3 point{};
  Vec3 normal{};

  static void declare(ParameterTable<HalfSpace>& table) {
    table.required("point", "m", &HalfSpace::point, any_number(), "A point of the plane.");
    table.required("normal", "1", &HalfSpace::normal, any_number(), "Direction out of the half-space, of any length but zero.");
  }
  bool contains(const Vec3& x) const override { return reaches(x, 0); }
  bool reaches(const Vec3& x, Real tolerance) const override {
    // Dividing by the largest component keeps tiny normals from underflow and makes planes along the axes exact.
    const Real scale = normal_scale();
    Real distance = 0;
    for (std::size_t d = 0; d < 3; ++d) distance += (x[d] - point[d]) * (normal[d] / scale);
    return distance <= tolerance;
  }
  Vec3 lower() const override { return bound(-1, -k_infinity); }
  Vec3 upper() const override { return bound(1, k_infinity); }
  std::optional<Real> measure(int) const override { return std::nullopt; }
  bool has_normal() const override { return true; }
  std::vector<Vec3> normals(const Vec3&, int) const override {
    const Real scale = normal_scale();
    const Real length = std::hypot(normal[0] / scale, normal[1] / scale, normal[2] / scale);
    return {{normal[0] / scale / length, normal[1] / scale / length, normal[2] / scale / length}};
  }
  std::optional<NearSurface> surface_near(const Vec3& x, int dim) const override {
    const Vec3 out = normals(x, dim)[0];
    return NearSurface{(x[0] - point[0]) * out[0] + (x[1] - point[1]) * out[1] + (x[2] - point[2]) * out[2], out};
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
  void check(const Input& input, const ReadContext& context) const override {
    if (normal_scale() > 0) return;
    fail_input(value_of(input, "normal"), context,
               fmt::format("normal = {} must not be zero, it gives the direction out of the half-space", value_of(input, "normal").text()));
  }

 private:
  Real normal_scale() const { return std::max({std::abs(normal[0]), std::abs(normal[1]), std::abs(normal[2])}); }
  /// A normal along an axis bounds one side of that axis; everything else reaches to infinity.
  Vec3 bound(Real sign, Real unbounded) const {
    Vec3 corner{unbounded, unbounded, unbounded};
    const Real scale = normal_scale();
    for (std::size_t d = 0; d < 3; ++d) {
      const bool is_along_axis = std::abs(normal[(d + 1) % 3]) == 0 && std::abs(normal[(d + 2) % 3]) == 0;
      if (is_along_axis && normal[d] == sign * scale) corner[d] = point[d];
    }
    return corner;
  }
};

struct Cylinder final : Region {
  static constexpr auto name = "cylinder";
  static constexpr auto summary = "A round cylinder between two points of its axis, 3D only.";

  Vec3 start{};
  Vec3 end{};
  Real radius = 1;

  static void declare(ParameterTable<Cylinder>& table) {
    table.custom(
        {"start", "m", "3 numbers", "", "", "The middle of one end.", true},
        [](Cylinder& cylinder, const Input& input, const ReadContext& context) {
          require_dim(3, input, context, "a cylinder exists in 3D only, use type = \"box\", or \"disk\" for its section");
          read_value(input, context, "start", any_number(), cylinder.start);
        },
        [](const Cylinder& cylinder, int dim) -> std::optional<Input> { return write_value(cylinder.start, dim); });
    table.required("end", "m", &Cylinder::end, any_number(), "The middle of the other end.");
    table.required("radius", "m", &Cylinder::radius, positive(), "Radius.");
  }
  bool contains(const Vec3& x) const override { return reaches(x, 0); }
  bool reaches(const Vec3& x, Real tolerance) const override {
    const Place at = place_of(x);
    return at.along >= -tolerance && at.along <= length() + tolerance && at.away <= radius + tolerance;
  }
  Vec3 lower() const override { return corner(-1); }
  Vec3 upper() const override { return corner(1); }
  std::optional<Real> measure(int) const override { return std::numbers::pi * radius * radius * length(); }
  bool has_normal() const override { return true; }
  std::vector<Vec3> normals(const Vec3& x, int) const override {
    const Vec3 a = axis();
    const Place at = place_of(x);
    std::vector<std::pair<Real, Vec3>> faces{{length() - at.along, a}, {at.along, {-a[0], -a[1], -a[2]}}};
    if (at.away > k_tie_tolerance * radius) {
      faces.emplace_back(radius - at.away, Vec3{at.out[0] / at.away, at.out[1] / at.away, at.out[2] / at.away});
    } else {
      // All directions across the axis are equally near: two of them, at right angles to each other.
      const auto least = static_cast<std::size_t>(
          std::min_element(a.begin(), a.end(), [](Real p, Real q) { return std::abs(p) < std::abs(q); }) - a.begin());
      Vec3 one{};
      for (std::size_t d = 0; d < 3; ++d) one[d] = (d == least ? 1 : 0) - a[least] * a[d];
      const Real size = std::hypot(one[0], one[1], one[2]);
      for (Real& c : one) c /= size;
      faces.emplace_back(radius, one);
      faces.emplace_back(radius, Vec3{a[1] * one[2] - a[2] * one[1], a[2] * one[0] - a[0] * one[2], a[0] * one[1] - a[1] * one[0]});
    }
    return nearest_normals(faces, std::max(radius, length()));
  }
  std::optional<NearSurface> surface_near(const Vec3& x, int dim) const override {
    const Vec3 a = axis();
    const Place at = place_of(x);
    const Real above = std::max(at.along - length(), -at.along), around = at.away - radius;
    if (above <= 0 || around <= 0) {
      // Across a flat end or the round side, or inside.
      if (above > around) {
        const Real sign = at.along - length() > -at.along ? 1 : -1;
        return NearSurface{above, {sign * a[0], sign * a[1], sign * a[2]}};
      }
      if (at.away > k_tie_tolerance * radius) return NearSurface{around, {at.out[0] / at.away, at.out[1] / at.away, at.out[2] / at.away}};
      return NearSurface{around, normals(x, dim).back()};
    }
    // At an edge.
    const Real distance = std::hypot(above, around);
    const Real sign = at.along > length() ? 1 : -1;
    NearSurface near{distance, {}};
    for (std::size_t d = 0; d < 3; ++d) near.normal[d] = (sign * above * a[d] + around * at.out[d] / at.away) / distance;
    return near;
  }
  std::optional<Solid> solid(int dim) const override {
    Solid solid{*measure(dim), {}, {}};
    const Vec3 a = axis();
    const Real along = solid.volume * radius * radius / 2, across = solid.volume * (3 * radius * radius + length() * length()) / 12;
    for (std::size_t i = 0; i < 3; ++i) {
      solid.center[i] = 0.5 * (start[i] + end[i]);
      for (std::size_t j = 0; j < 3; ++j) solid.inertia[3 * i + j] = (i == j ? across : 0) + (along - across) * a[i] * a[j];
    }
    return solid;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
  void check(const Input& input, const ReadContext& context) const override {
    if (!(length() > 0)) fail_input(value_of(input, "end"), context, "end must be another point than start, they give the axis");
    check_measure(*this, input, context);
  }

 private:
  struct Place {
    Real along, away;  ///< The axis from its start, and from it [m].
    Vec3 out;          ///< From the axis to the point [m].
  };
  Real length() const { return std::hypot(end[0] - start[0], end[1] - start[1], end[2] - start[2]); }
  Vec3 axis() const {
    const Real size = length();
    return {(end[0] - start[0]) / size, (end[1] - start[1]) / size, (end[2] - start[2]) / size};
  }
  Place place_of(const Vec3& x) const {
    const Vec3 a = axis();
    Place at{0, 0, {}};
    for (std::size_t d = 0; d < 3; ++d) at.along += (x[d] - start[d]) * a[d];
    for (std::size_t d = 0; d < 3; ++d) at.out[d] = x[d] - start[d] - at.along * a[d];
    at.away = std::hypot(at.out[0], at.out[1], at.out[2]);
    return at;
  }
  Vec3 corner(Real sign) const {
    const Vec3 a = axis();
    Vec3 corner{};
    for (std::size_t d = 0; d < 3; ++d) {
      const Real reach = sign * radius * std::sqrt(std::max(Real{0}, 1 - a[d] * a[d]));
      corner[d] = sign * std::max(sign * start[d], sign * end[d]) + reach;
    }
    return corner;
  }
};

/// The key `of` of unions and differences.
template <class T>
void declare_parts(ParameterTable<T>& table, const std::string& help) {
  table.custom(
      {"of", "1", "array of regions", "", "at least 2 regions", help, true},
      [](T& object, const Input& input, const ReadContext& context) {
        if (input.kind() != Input::Kind::array) {
          fail_input(input, context, fmt::format("of must be an array of regions, got {} ({})", input.text(), input.kind_text()));
        }
        if (input.items().size() < 2) {
          fail_input(input, context, fmt::format("of has {} regions, a {} needs at least 2", input.items().size(), T::name));
        }
        object.of.clear();
        for (std::size_t i = 0; i < input.items().size(); ++i) {
          object.of.push_back(region_registry().read(input.items()[i], context, fmt::format("of[{}]", i)));
        }
      },
      [](const T& object, int dim) -> std::optional<Input> {
        Input parts = Input::array();
        for (const RegionPointer& part : object.of) parts.items().push_back(part->write(dim));
        return parts;
      });
}

struct Union final : Region {
  static constexpr auto name = "union";
  static constexpr auto summary = "Everything that is in at least one of several regions.";

  std::vector<RegionPointer> of;

  static void declare(ParameterTable<Union>& table) { declare_parts(table, "The regions that are joined."); }
  bool contains(const Vec3& x) const override {
    return std::any_of(of.begin(), of.end(), [&](const RegionPointer& part) { return part->contains(x); });
  }
  bool reaches(const Vec3& x, Real tolerance) const override {
    return std::any_of(of.begin(), of.end(), [&](const RegionPointer& part) { return part->reaches(x, tolerance); });
  }
  Vec3 lower() const override {
    Vec3 corner{k_infinity, k_infinity, k_infinity};
    for (const RegionPointer& part : of) {
      const Vec3 other = part->lower();
      for (std::size_t d = 0; d < 3; ++d) corner[d] = std::min(corner[d], other[d]);
    }
    return corner;
  }
  Vec3 upper() const override {
    Vec3 corner{-k_infinity, -k_infinity, -k_infinity};
    for (const RegionPointer& part : of) {
      const Vec3 other = part->upper();
      for (std::size_t d = 0; d < 3; ++d) corner[d] = std::max(corner[d], other[d]);
    }
    return corner;
  }
  std::optional<Real> measure(int) const override { return std::nullopt; }
  std::optional<NearSurface> surface_near(const Vec3& x, int dim) const override {
    std::optional<NearSurface> nearest;
    for (const RegionPointer& part : of) {
      const std::optional<NearSurface> near = part->surface_near(x, dim);
      if (!near) return std::nullopt;
      if (!nearest || near->distance < nearest->distance) nearest = near;
    }
    return nearest;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

struct Difference final : Region {
  static constexpr auto name = "difference";
  static constexpr auto summary = "The first of several regions without the others; its bounding box is that of the first.";

  std::vector<RegionPointer> of;

  static void declare(ParameterTable<Difference>& table) {
    declare_parts(table, "The region to start from, then the regions that are cut out of it, their boundaries included.");
  }
  bool contains(const Vec3& x) const override {
    return of.front()->contains(x) && std::none_of(of.begin() + 1, of.end(), [&](const RegionPointer& part) { return part->contains(x); });
  }
  /// What is cut out is closed: its nodes are out, also those that rounding has moved off its faces.
  bool reaches(const Vec3& x, Real tolerance) const override {
    return of.front()->reaches(x, tolerance) &&
           std::none_of(of.begin() + 1, of.end(), [&](const RegionPointer& part) { return part->reaches(x, tolerance); });
  }
  Vec3 lower() const override { return of.front()->lower(); }
  Vec3 upper() const override { return of.front()->upper(); }
  std::optional<Real> measure(int) const override { return std::nullopt; }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

}  // namespace

template <int Dim>
void Ball<Dim>::declare(ParameterTable<Ball>& table) {
  table.custom(
      {"center", "m", type_text<Vec3>(), "", "", "Center.", true},
      [](Ball& ball, const Input& input, const ReadContext& context) {
        require_dim(Dim, input, context,
                    Dim == 2 ? "a disk exists in 2D only, use type = \"sphere\"" : "a sphere exists in 3D only, use type = \"disk\"");
        read_value(input, context, "center", any_number(), ball.center);
      },
      [](const Ball& ball, int dim) -> std::optional<Input> { return write_value(ball.center, dim); });
  table.required("radius", "m", &Ball::radius, positive(), "Radius.");
}

template <int Dim>
bool Ball<Dim>::reaches(const Vec3& x, Real tolerance) const {
  Real distance_squared = 0;
  for (std::size_t d = 0; d < Dim; ++d) distance_squared += (x[d] - center[d]) * (x[d] - center[d]);
  const Real reach = radius + tolerance;
  return distance_squared <= reach * reach;
}

template <int Dim>
Vec3 Ball<Dim>::lower() const {
  Vec3 corner = center;
  for (std::size_t d = 0; d < Dim; ++d) corner[d] -= radius;
  return corner;
}

template <int Dim>
Vec3 Ball<Dim>::upper() const {
  Vec3 corner = center;
  for (std::size_t d = 0; d < Dim; ++d) corner[d] += radius;
  return corner;
}

template <int Dim>
std::optional<Real> Ball<Dim>::measure(int) const {
  return Dim == 2 ? std::numbers::pi * radius * radius : 4 * std::numbers::pi / 3 * radius * radius * radius;
}

template <int Dim>
std::vector<Vec3> Ball<Dim>::normals(const Vec3& x, int) const {
  const Vec3 r{x[0] - center[0], x[1] - center[1], Dim == 3 ? x[2] - center[2] : 0};
  const Real distance = std::hypot(r[0], r[1], r[2]);
  // All directions are equally near at the centre.
  if (distance <= k_tie_tolerance * radius) return {{1, 0, 0}, {0, 1, 0}, {0, 0, Dim == 3 ? 1.0 : 0.0}};
  return {{r[0] / distance, r[1] / distance, r[2] / distance}};
}

template <int Dim>
std::optional<NearSurface> Ball<Dim>::surface_near(const Vec3& x, int dim) const {
  return NearSurface{std::hypot(x[0] - center[0], x[1] - center[1], Dim == 3 ? x[2] - center[2] : 0) - radius, normals(x, dim)[0]};
}

template <int Dim>
std::optional<Solid> Ball<Dim>::solid(int dim) const {
  Solid solid{*measure(dim), center, {}};
  const Real moment = (Dim == 3 ? 0.4 : 0.5) * solid.volume * radius * radius;
  for (std::size_t d = 0; d < 3; ++d) solid.inertia[4 * d] = moment;
  return solid;
}

template <int Dim>
Input Ball<Dim>::write(int dim) const {
  return write_typed(*this, dim);
}

template <int Dim>
void Ball<Dim>::check(const Input& input, const ReadContext& context) const {
  check_measure(*this, input, context);
}

Real node_tolerance(const Vec3& x, Real cell_size) {
  constexpr Real k_share = 1e-9;
  const Real farthest = std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
  return k_share * cell_size + 4 * std::numeric_limits<Real>::epsilon() * farthest;
}

template struct Ball<2>;
template struct Ball<3>;

const TypeRegistry<Region>& region_registry() {
  static const TypeRegistry<Region> registry = [] {
    TypeRegistry<Region> all;
    all.add<Box>();
    all.add<Disk>();
    all.add<Sphere>();
    all.add<Cylinder>();
    add_polygon(all);
    all.add<HalfSpace>();
    all.add<Union>();
    all.add<Difference>();
    return all;
  }();
  return registry;
}

}  // namespace matpoint
