// The polygon: the one region whose outline a case draws itself.
#include <numeric>

#include "core/error.hpp"
#include "geometry/region_parts.hpp"

namespace matpoint {
namespace {

using namespace region_parts;

// A simple polygon. A point is inside when a ray from it crosses the edges an odd number of times (Shimrat, 1962), or when it lies on
// an edge; the ray alone decides edge points by rounding.
struct Polygon final : Region {
  static constexpr auto name = "polygon";
  static constexpr auto summary = "A polygon of at least 3 vertices, which do not have to be convex, 2D only; 3 vertices make a triangle.";

  std::vector<Vec3> vertices;
  Vec3 lower_corner{};
  Vec3 upper_corner{};

  static void declare(ParameterTable<Polygon>& table) {
    table.custom(
        {"vertices", "m", type_text<std::vector<Vec3>>(), "", "at least 3 points, no two edges cross",
         "Corners one after the other, clockwise or not; the last is joined to the first.", true},
        [](Polygon& polygon, const Input& input, const ReadContext& context) {
          require_dim(2, input, context,
                      "a polygon exists in 2D only; in 3D use \"box\", \"sphere\", \"cylinder\" and their unions and differences");
          read_value(input, context, "vertices", any_number(), polygon.vertices);
          polygon.find_box();
        },
        [](const Polygon& polygon, int dim) -> std::optional<Input> { return write_value(polygon.vertices, dim); });
  }
  bool contains(const Vec3& x) const override { return reaches(x, 0); }
  bool reaches(const Vec3& x, Real beyond) const override {
    const Real tolerance = std::max(beyond, k_edge_tolerance * size());
    for (std::size_t d = 0; d < 2; ++d) {
      if (!(x[d] >= lower_corner[d] - tolerance && x[d] <= upper_corner[d] + tolerance)) return false;
    }
    bool is_inside = false;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Vec3& a = vertices[i];
      const Vec3& b = end_of(i);
      if (distance_to_edge(x, a, b) <= tolerance) return true;
      const bool is_crossed = (a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (x[1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1]);
      if (is_crossed) is_inside = !is_inside;
    }
    return is_inside;
  }
  Vec3 lower() const override { return lower_corner; }
  Vec3 upper() const override { return upper_corner; }
  std::optional<Real> measure(int) const override {
    Real twice = 0;
    for (std::size_t i = 0; i < vertices.size(); ++i) twice += cross(vertices[0], vertices[i], end_of(i));
    return std::abs(twice) / 2;
  }
  bool has_normal() const override { return true; }
  std::vector<Vec3> normals(const Vec3& x, int) const override {
    Real twice = 0;
    for (std::size_t i = 0; i < vertices.size(); ++i) twice += cross(vertices[0], vertices[i], end_of(i));
    const Real outward = twice > 0 ? 1 : -1;  // the outline may run either way
    std::vector<std::pair<Real, Vec3>> faces;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Vec3& a = vertices[i];
      const Vec3& b = end_of(i);
      const Real length = std::hypot(b[0] - a[0], b[1] - a[1]);
      faces.emplace_back(distance_to_edge(x, a, b), Vec3{outward * (b[1] - a[1]) / length, -outward * (b[0] - a[0]) / length, 0});
    }
    return nearest_normals(faces, size());
  }
  std::optional<NearSurface> surface_near(const Vec3& x, int dim) const override {
    Real least = k_infinity;
    Vec3 way{};
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Vec3 foot = nearest_on_edge(x, vertices[i], end_of(i));
      const Real distance = std::hypot(x[0] - foot[0], x[1] - foot[1]);
      if (distance >= least) continue;
      least = distance;
      way = {x[0] - foot[0], x[1] - foot[1], 0};
    }
    if (least <= k_edge_tolerance * size()) return NearSurface{0, normals(x, dim)[0]};
    const Real sign = reaches(x, 0) ? -1 : 1;
    return NearSurface{sign * least, {sign * way[0] / least, sign * way[1] / least, 0}};
  }
  std::optional<Solid> solid(int) const override {
    // Sums over triangles from the first vertex, which count as negative where the outline runs the other way.
    Solid solid;
    Real twice = 0, moment = 0;
    Vec3 first{};
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Vec3 &o = vertices[0], &a = vertices[i], &b = end_of(i);
      const Real area = cross(o, a, b);
      const Real ax = a[0] - o[0], ay = a[1] - o[1], bx = b[0] - o[0], by = b[1] - o[1];
      twice += area;
      first[0] += area * (ax + bx) / 3;
      first[1] += area * (ay + by) / 3;
      moment += area * (ax * ax + ax * bx + bx * bx + ay * ay + ay * by + by * by) / 12;
    }
    const Vec3 from{first[0] / twice, first[1] / twice, 0};
    solid.volume = std::abs(twice) / 2;
    solid.center = {vertices[0][0] + from[0], vertices[0][1] + from[1], 0};
    solid.inertia[8] = std::abs(moment) - solid.volume * (from[0] * from[0] + from[1] * from[1]);
    return solid;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
  void check(const Input& input, const ReadContext& context) const override {
    const Input& given = value_of(input, "vertices");
    if (vertices.size() < 3) {
      fail_input(given, context, fmt::format("vertices has {} points, a polygon needs at least 3", vertices.size()));
    }
    check_neighbours(given, context);
    check_crossings(given, context);
    // Round-off of the shoelace sum is a few eps of size^2; a thinner polygon has an area by accident only.
    if (!(*measure(2) > 1e-14 * size() * size())) {
      fail_input(given, context, "the polygon's area is zero, its vertices lie on a line");
    }
    check_measure(*this, input, context);
  }

 private:
  /// Points this near to an edge, relative to the larger side of the bounding box, are on it.
  static constexpr Real k_edge_tolerance = 1e-12;

  const Vec3& end_of(std::size_t edge) const { return vertices[(edge + 1) % vertices.size()]; }
  Real size() const { return std::max(upper_corner[0] - lower_corner[0], upper_corner[1] - lower_corner[1]); }

  void find_box() {
    if (vertices.empty()) return;
    lower_corner = upper_corner = vertices[0];
    for (const Vec3& vertex : vertices) {
      for (std::size_t d = 0; d < 2; ++d) {
        lower_corner[d] = std::min(lower_corner[d], vertex[d]);
        upper_corner[d] = std::max(upper_corner[d], vertex[d]);
      }
    }
  }

  /// (b - a) x (c - a) [m^2]: positive when c is to the left of the way from a to b.
  static Real cross(const Vec3& a, const Vec3& b, const Vec3& c) { return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]); }
  static Vec3 nearest_on_edge(const Vec3& x, const Vec3& a, const Vec3& b) {
    const Real length_squared = (b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]);
    const Real along = (x[0] - a[0]) * (b[0] - a[0]) + (x[1] - a[1]) * (b[1] - a[1]);
    const Real t = std::clamp(along / length_squared, Real{0}, Real{1});
    return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), 0};
  }
  static Real distance_to_edge(const Vec3& x, const Vec3& a, const Vec3& b) {
    const Vec3 foot = nearest_on_edge(x, a, b);
    return std::hypot(x[0] - foot[0], x[1] - foot[1]);
  }
  /// Whether p, known to lie on the line through a and b, lies between them.
  static bool is_between(const Vec3& a, const Vec3& b, const Vec3& p) {
    return p[0] >= std::min(a[0], b[0]) && p[0] <= std::max(a[0], b[0]) && p[1] >= std::min(a[1], b[1]) && p[1] <= std::max(a[1], b[1]);
  }
  static bool do_meet(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const Real abc = cross(a, b, c), abd = cross(a, b, d), cda = cross(c, d, a), cdb = cross(c, d, b);
    if (abc == 0 && is_between(a, b, c)) return true;
    if (abd == 0 && is_between(a, b, d)) return true;
    if (cda == 0 && is_between(c, d, a)) return true;
    if (cdb == 0 && is_between(c, d, b)) return true;
    return (abc > 0) != (abd > 0) && (cda > 0) != (cdb > 0) && abc != 0 && abd != 0 && cda != 0 && cdb != 0;
  }

  /// Two vertices in one point, and edges that run back over the one before them.
  void check_neighbours(const Input& given, const ReadContext& context) const {
    const std::size_t n = vertices.size();
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = (i + 1) % n;
      if (vertices[i] == vertices[j]) {
        fail_input(
            given, context,
            fmt::format("vertices[{}] and vertices[{}] are the same point {}; leave one out (the last vertex is joined to the first)", i, j,
                        given.items()[i].text()));
      }
    }
    if (n == 3) return;  // A triangle that folds back has no area, which is the clearer complaint.
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 &a = vertices[i], &b = end_of(i), &c = end_of((i + 1) % n);
      const Real forward = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
      if (cross(a, b, c) == 0 && forward < 0) {
        fail_input(given, context,
                   fmt::format("the polygon folds back on itself at vertices[{}] = {}", (i + 1) % n, given.items()[(i + 1) % n].text()));
      }
    }
  }

  /// Edges sorted by their smallest x are compared only while they overlap in x: next to linear for the outlines that people draw.
  void check_crossings(const Input& given, const ReadContext& context) const {
    const std::size_t n = vertices.size();
    const auto start = [&](std::size_t i) { return std::min(vertices[i][0], end_of(i)[0]); };
    const auto end = [&](std::size_t i) { return std::max(vertices[i][0], end_of(i)[0]); };
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t i, std::size_t j) { return start(i) < start(j) || (start(i) == start(j) && i < j); });
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t l = k + 1; l < n && start(order[l]) <= end(order[k]); ++l) {
        const auto [i, j] = std::minmax(order[k], order[l]);
        const bool are_neighbours = j == i + 1 || (i == 0 && j == n - 1);
        if (are_neighbours || !do_meet(vertices[i], end_of(i), vertices[j], end_of(j))) continue;
        fail_input(
            given, context,
            fmt::format(
                "the polygon crosses or touches itself: the edge from vertices[{}] to vertices[{}] meets the edge from vertices[{}] to "
                "vertices[{}]",
                i, i + 1, j, (j + 1) % n));
      }
    }
  }
};

}  // namespace

void add_polygon(TypeRegistry<Region>& registry) { registry.add<Polygon>(); }

}  // namespace matpoint
