#include "body/particle_load.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "body/fill_body.hpp"
#include "core/error.hpp"
#include "geometry/seed_surface.hpp"

namespace matpoint {
namespace {

/// Radius of the mean normal of a staircase, in spacings: its steps are one spacing high, and a slope of 1 : 3 has one in three.
constexpr Real k_smoothing = 2.5;

/// Mean of the normals of the faces around each, weighted by their areas: what is smooth under a staircase. Faces that look one way keep
/// their own.
std::vector<Vec3> smooth_normals(const std::vector<SeedFace>& faces, Real spacing, int dim) {
  std::vector<Vec3> normals(faces.size());
  // By boxes of the radius of the mean, so that only neighbours are asked.
  const Real radius = k_smoothing * spacing;
  const auto box_of = [&](const Vec3& x) {
    std::array<Index, 3> box{};
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) box[d] = static_cast<Index>(std::floor(x[d] / radius));
    return box;
  };
  std::vector<std::pair<std::array<Index, 3>, std::size_t>> sorted;
  for (std::size_t k = 0; k < faces.size(); ++k) sorted.emplace_back(box_of(faces[k].center), k);
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const std::array<Index, 3> own = box_of(faces[k].center);
    Vec3 sum{};
    for (Index i = own[0] - 1; i <= own[0] + 1; ++i) {
      for (Index j = own[1] - 1; j <= own[1] + 1; ++j) {
        for (Index l = own[2] - (dim == 3 ? 1 : 0); l <= own[2] + (dim == 3 ? 1 : 0); ++l) {
          const std::array<Index, 3> box{i, j, l};
          for (auto near = std::lower_bound(sorted.begin(), sorted.end(), std::make_pair(box, std::size_t{0}));
               near != sorted.end() && near->first == box; ++near) {
            const SeedFace& face = faces[near->second];
            Real distance = 0;
            for (std::size_t d = 0; d < 3; ++d) distance += std::pow(face.center[d] - faces[k].center[d], 2);
            if (distance <= radius * radius) sum[static_cast<std::size_t>(face.axis)] += (face.is_upper ? 1 : -1) * face.area;
          }
        }
      }
    }
    const Real length = std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    for (std::size_t d = 0; d < 3 && length > 0; ++d) normals[k][d] = sum[d] / length;
  }
  return normals;
}

/// Whether a face at the start lies on a side of the grid that something holds or that is periodic, and so is no free surface.
bool is_closed(const SeedFace& face, const Case& problem, const SeedingGrid& grid, Real spacing) {
  if (problem.grid.is_mapped()) return false;
  const auto axis = static_cast<std::size_t>(face.axis);
  const Real side = face.is_upper ? grid.upper[axis] : grid.lower[axis];
  if (std::abs(face.center[axis] - side) > 1e-6 * spacing) return false;
  if (grid.has_axis && face.axis == 0 && side == 0) return true;
  const std::vector<std::string>& periodic = problem.grid.periodic;
  if (std::find(periodic.begin(), periodic.end(), std::string(1, "xyz"[axis])) != periodic.end()) return true;
  return std::any_of(problem.boundaries.begin(), problem.boundaries.end(), [&](const BoundarySpec& boundary) {
    if (boundary.region || boundary.kind == BoundaryKind::traction) return false;
    const BoundarySide held = side_of(boundary.side);
    return held.axis == face.axis && held.is_upper == face.is_upper;
  });
}

/// M^-1 for Dim x Dim numbers, row by row.
template <int Dim>
std::array<Real, Dim * Dim> inverse(const Real* F) {
  const auto cof = cofactors<Dim>(F);
  Real det = 0;
  for (std::size_t d = 0; d < Dim; ++d) det += F[d] * cof[d];
  std::array<Real, Dim * Dim> result;
  for (std::size_t i = 0; i < Dim; ++i) {
    for (std::size_t j = 0; j < Dim; ++j) result[i * Dim + j] = cof[j * Dim + i] / det;
  }
  return result;
}

template <int Dim>
Vec<Dim> product(const std::array<Real, Dim * Dim>& a, const Vec<Dim>& b) {
  Vec<Dim> result{};
  for (std::size_t i = 0; i < Dim; ++i) {
    for (std::size_t j = 0; j < Dim; ++j) result[i] += a[i * Dim + j] * b[j];
  }
  return result;
}

}  // namespace

template <int Dim>
std::array<Real, Dim * Dim> cofactors(const Real* F) {
  if constexpr (Dim == 2)
    return {F[3], -F[2], -F[1], F[0]};
  else
    return {F[4] * F[8] - F[5] * F[7], F[5] * F[6] - F[3] * F[8], F[3] * F[7] - F[4] * F[6],
            F[2] * F[7] - F[1] * F[8], F[0] * F[8] - F[2] * F[6], F[1] * F[6] - F[0] * F[7],
            F[1] * F[5] - F[2] * F[4], F[2] * F[3] - F[0] * F[5], F[0] * F[4] - F[1] * F[3]};
}

template <int Dim>
ParticleLoad<Dim>::ParticleLoad(const Case& problem, std::size_t load, const SeedingGrid& grid)
    : spec_(problem.loads[load]), name_(load_names(problem.loads)[load]) {
  const std::string where = fmt::format("{}{}load {}", spec_.place, spec_.place.empty() ? "" : ": ", name_);
  while (problem.bodies[body_].name != spec_.body) ++body_;
  const BodySpec& body = problem.bodies[body_];
  const Seeds seeds = fill_body(body, grid);
  const Real least = std::pow(*std::min_element(seeds.volume.begin(), seeds.volume.end()), Real{1} / Dim);  // a spacing
  const auto is_in = [&](const Vec3& x) { return !spec_.region || spec_.region->reaches(x, node_tolerance(x, least)); };
  const auto add = [&](std::size_t seed, const Face& face) {
    if (ids_.empty() || ids_.back() != static_cast<Index>(seed)) {
      ids_.push_back(static_cast<Index>(seed));
      first_face_.push_back(faces_.size());
    }
    faces_.push_back(face);
  };
  const auto ring = [&](Real radius) { return grid.has_axis ? 2 * std::numbers::pi * radius : Real{1}; };
  if (spec_.is_on_surface()) {
    std::vector<SeedFace> faces;
    try {
      faces = surface_of(seeds, body.region.get(), Dim);
    } catch (const InputError& error) {
      throw InputError("{}: body \"{}\": {}", where, body.name, error.what());
    }
    std::erase_if(faces, [&](const SeedFace& face) {
      if (!is_in(face.center) || is_closed(face, problem, grid, least)) return true;
      if (spec_.side.empty()) return false;
      const BoundarySide side = side_of(spec_.side);
      return face.axis != side.axis || face.is_upper != side.is_upper;
    });
    const bool is_dead = spec_.kind != LoadKind::pressure;
    const std::vector<Vec3> normals = is_dead ? smooth_normals(faces, least, Dim) : std::vector<Vec3>{};
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const SeedFace& face = faces[f];
      const auto axis = static_cast<std::size_t>(face.axis);
      const Real area = face.area * ring(face.center[0]);
      const Real n = face.is_upper ? 1 : -1;
      Face carried;
      carried.area[axis] = n * area;
      carried.size = is_dead ? area * std::max(Real{0}, n * normals[f][axis]) : area;
      carried.arm[axis] = n * face.depth;
      add(face.seed, carried);
    }
  } else {
    for (std::size_t p = 0; p < seeds.position.size(); ++p) {
      Face carried;
      carried.size = seeds.volume[p] * ring(seeds.position[p][0]);
      if (is_in(seeds.position[p])) add(p, carried);
    }
  }
  first_face_.push_back(faces_.size());
  if (ids_.empty()) {
    const std::string side = spec_.side.empty() ? "" : fmt::format(" to the {} side", spec_.side);
    throw InputError("{}: {} of body \"{}\"{}; {}", where,
                     spec_.is_on_surface() ? fmt::format("no face of the free surface{}", side) : "no particle", body.name,
                     spec_.region ? " has its middle in the region" : "",
                     spec_.is_on_surface() ? "what lies on a side of the grid with a boundary is not free" : "enlarge the region");
  }
  if (spec_.kind != LoadKind::force) return;
  Real sum = 0;
  for (const Face& face : faces_) sum += face.size;
  for (Face& face : faces_) face.size /= sum;
}

template <int Dim>
void ParticleLoad<Dim>::refer_to(const std::vector<Real>& F, const std::vector<Real>& F33) {
  for (std::size_t k = 0; k < ids_.size(); ++k) {
    const Real* const f = F.data() + k * Dim * Dim;
    // n A at the start is J F^-T of what it would be without F, and X is F X.
    std::array<Real, Dim* Dim> of_area = inverse<Dim>(cofactors<Dim>(f).data());
    for (Real& x : of_area) x /= F33[k];
    const std::array<Real, Dim* Dim> of_arm = inverse<Dim>(f);
    for (std::size_t face = first_face_[k]; face < first_face_[k + 1]; ++face) {
      faces_[face].area = product<Dim>(of_area, faces_[face].area);
      faces_[face].arm = product<Dim>(of_arm, faces_[face].arm);
    }
  }
}

template <int Dim>
PointForce<Dim> ParticleLoad<Dim>::on(std::size_t number, Real factor, const Real* F, Real F33) const {
  const Face& face = faces_[number];
  PointForce<Dim> load{{}, face.arm};
  if (follows()) {
    load.force = product<Dim>(cofactors<Dim>(F), face.area);
    for (Real& f : load.force) f *= -factor * spec_.pressure * F33;
    return load;
  }
  const std::vector<Real>& along = spec_.kind == LoadKind::traction ? spec_.traction : spec_.force;
  for (std::size_t d = 0; d < Dim; ++d) load.force[d] = factor * along[d] * face.size;
  return load;
}

template <int Dim>
std::vector<ParticleLoad<Dim>> particle_loads(const Case& problem, const SeedingGrid& grid) {
  std::vector<ParticleLoad<Dim>> loads;
  for (std::size_t k = 0; k < problem.loads.size(); ++k) loads.emplace_back(problem, k, grid);
  return loads;
}

template class ParticleLoad<2>;
template class ParticleLoad<3>;
template std::array<Real, 4> cofactors<2>(const Real*);
template std::array<Real, 9> cofactors<3>(const Real*);
template std::vector<ParticleLoad<2>> particle_loads(const Case&, const SeedingGrid&);
template std::vector<ParticleLoad<3>> particle_loads(const Case&, const SeedingGrid&);

}  // namespace matpoint
