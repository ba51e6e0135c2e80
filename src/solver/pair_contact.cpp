#include "solver/pair_contact.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.hpp"

namespace matpoint {
namespace {

// Of W, in spacings: wide enough that lattices are smooth, and 33 neighbours in 3D at a flat surface.
constexpr Real k_range = 2.5;
constexpr Real k_exponent = 4;

// Particles per piece of work.
constexpr std::size_t k_piece = 64;

template <int Dim>
Real squared(const Vec<Dim>& a) {
  Real sum = 0;
  for (const Real x : a) sum += x * x;
  return sum;
}

template <int Dim>
Real dot(const Vec<Dim>& a, const Vec<Dim>& b) {
  Real sum = 0;
  for (std::size_t d = 0; d < Dim; ++d) sum += a[d] * b[d];
  return sum;
}

template <int Dim>
Vec<Dim> scaled(Vec<Dim> a, Real factor) {
  for (Real& x : a) x *= factor;
  return a;
}

/// The part of a across the normal.
template <int Dim>
Vec<Dim> along(Vec<Dim> a, const Vec<Dim>& normal) {
  const Real across = dot<Dim>(a, normal);
  for (std::size_t d = 0; d < Dim; ++d) a[d] -= across * normal[d];
  return a;
}

/// A neighbour of the other body.
struct Near {
  std::uint32_t point;
  Real q;  ///< 1 - d^2 / R^2
};

template <int Dim>
struct Box {
  Vec<Dim> lower;
  Vec<Dim> upper;
};

/// How far boxes are apart along the direction in which they are most so; negative where they overlap.
template <int Dim>
Real gap_of(const Box<Dim>& a, const Box<Dim>& b) {
  Real gap = -std::numeric_limits<Real>::infinity();
  for (std::size_t d = 0; d < Dim; ++d) gap = std::max({gap, b.lower[d] - a.upper[d], a.lower[d] - b.upper[d]});
  return gap;
}

/// Square cells, numbered with x fastest, over a box.
template <int Dim>
class Cells {
 public:
  Cells(const Box<Dim>& box, Real size) : lower_(box.lower), size_(size) {
    for (std::size_t d = 0; d < Dim; ++d) counts_[d] = 1 + static_cast<Index>((box.upper[d] - box.lower[d]) / size);
  }
  std::array<Index, Dim> cell_of(const Vec<Dim>& x) const {
    std::array<Index, Dim> cell;
    for (std::size_t d = 0; d < Dim; ++d) cell[d] = std::clamp<Index>(static_cast<Index>((x[d] - lower_[d]) / size_), 0, counts_[d] - 1);
    return cell;
  }
  Index key_of(const std::array<Index, Dim>& cell) const {
    Index key = 0;
    for (std::size_t d = Dim; d-- > 0;) key = key * counts_[d] + cell[d];
    return key;
  }
  /// Calls f(first key, last key) for the rows of cells around the one with x.
  template <class F>
  void for_each_row_near(const Vec<Dim>& x, F&& f) const {
    const std::array<Index, Dim> middle = cell_of(x);
    std::array<Index, Dim> cell = middle;
    const Index first = std::max<Index>(middle[0] - 1, 0);
    const Index last = std::min(middle[0] + 1, counts_[0] - 1);
    for (int row = 0; row < (Dim == 3 ? 9 : 3); ++row) {
      bool exists = true;
      for (std::size_t d = 1; d < Dim; ++d) {
        cell[d] = middle[d] + (d == 1 ? row % 3 : row / 3) - 1;
        exists = exists && cell[d] >= 0 && cell[d] < counts_[d];
      }
      if (!exists) continue;
      cell[0] = first;
      const Index key = key_of(cell);
      f(key, key + last - first);
    }
  }

 private:
  Vec<Dim> lower_;
  Real size_;
  std::array<Index, Dim> counts_;
};

}  // namespace

template <int Dim>
PairKernel<Dim>::PairKernel(Real range)
    : range_(range),
      alpha_(std::tgamma(k_exponent + 1 + 0.5 * Dim) /
             (std::pow(std::numbers::pi, 0.5 * Dim) * std::tgamma(k_exponent + 1) * std::pow(range, Dim))) {}

template <int Dim>
Real PairKernel<Dim>::over_plane(Real z) const {
  // Over a plane W integrates to a power of the same form, half a power higher per direction of the plane.
  const Real exponent = k_exponent + 0.5 * (Dim - 1);
  const Real q = 1 - z * z / (range_ * range_);
  if (q <= 0) return 0;
  return std::tgamma(exponent + 1.5) / (std::sqrt(std::numbers::pi) * std::tgamma(exponent + 1) * range_) * std::pow(q, exponent);
}

template <int Dim>
Real PairKernel<Dim>::beyond_plane(Real z) const {
  // Simpson's rule; the function is smooth, and 100 intervals are good for ten digits.
  constexpr int k_intervals = 100;
  if (z >= range_) return 0;
  const Real h = (range_ - z) / k_intervals;
  Real sum = 0;
  for (int i = 0; i <= k_intervals; ++i) {
    const Real weight = i == 0 || i == k_intervals ? 1 : i % 2 == 1 ? 4 : 2;
    sum += weight * over_plane(z + i * h);
  }
  return sum * h / 3;
}

/// All particles of a body.
template <int Dim>
struct PairContact<Dim>::Points {
  const Body<Dim>* body;
  std::size_t number;  ///< Of the body.
  Real density;        ///< [kg/m^3]
  Real modulus;        ///< rho c^2 [Pa]
  std::vector<Real> position;
  std::vector<Real> velocity;
  std::vector<Index> ids;     ///< Of the rows.
  std::vector<Real> volumes;  ///< In the reference configuration [m^dim].
  Real spacing = 0;           ///< The largest [m].
  Box<Dim> box{};
  Real speed = 0;  ///< The greatest [m/s].
  std::vector<Real> forces;
  std::vector<Index> forced;  ///< Ids with a force.

  /// What changes only when particles are taken out.
  void read_constants() {
    const std::vector<Real> numbers = body->field("id", number).values;
    const std::vector<Real> masses = body->field("mass", number).values;
    ids.resize(numbers.size());
    volumes.resize(numbers.size());
    for (std::size_t row = 0; row < ids.size(); ++row) {
      ids[row] = static_cast<Index>(numbers[row]);
      volumes[row] = masses[row] / density;
    }
  }
  Vec<Dim> row_of(const std::vector<Real>& field, std::size_t row) const {
    Vec<Dim> x;
    std::copy_n(field.begin() + static_cast<std::ptrdiff_t>(row * Dim), Dim, x.begin());
    return x;
  }
  void read_places() {
    if (static_cast<std::size_t>(body->particle_count()) != ids.size()) read_constants();
    position = body->field("position", number).values;
    box.lower.fill(std::numeric_limits<Real>::infinity());
    box.upper.fill(-std::numeric_limits<Real>::infinity());
    for (std::size_t k = 0; k < position.size(); ++k) {
      box.lower[k % Dim] = std::min(box.lower[k % Dim], position[k]);
      box.upper[k % Dim] = std::max(box.upper[k % Dim], position[k]);
    }
    for (const Index id : forced) std::fill_n(forces.begin() + static_cast<std::ptrdiff_t>(id * Dim), Dim, 0);
    forced.clear();
  }
};

/// Two bodies.
template <int Dim>
struct PairContact<Dim>::Pair {
  std::array<std::size_t, 2> bodies;
  PairKernel<Dim> kernel;
  Real stiffness;                             ///< K [Pa]
  std::array<std::vector<Real>, 2> at_touch;  ///< c0 of each particle, by id [1].
  std::array<std::vector<Hold>, 2> holds;     ///< Ascending ids.
};

/// The particles of one body that are near another one.
template <int Dim>
struct PairContact<Dim>::Side {
  Points& of;
  const PairKernel<Dim>& kernel;
  const std::vector<Real>& at_touch;
  Real stiffness;  ///< K [Pa]
  Cells<Dim> cells;
  std::vector<std::size_t> rows;  ///< Of the particles in the fields of the body.
  std::vector<Index> keys;        ///< Of the cells; ascending.
  std::vector<Vec<Dim>> x;
  std::vector<Real> volume;
  std::vector<std::vector<Near>> near;  ///< Of each piece, one particle after the other.
  std::vector<std::size_t> begin;       ///< Of a particle's neighbours in those of its piece.
  std::vector<std::size_t> end;
  std::vector<Real> c;
  std::vector<Real> pressure;  ///< K <c - c0> [Pa]
  std::vector<Real> energy;    ///< [J]
  std::vector<Vec<Dim>> force;
  std::vector<Vec<Dim>> own_force;  ///< The share of `force` from the particle's own part of Phi.
  std::vector<Vec<Dim>> friction;
  std::vector<Hold> holds;
  std::vector<Real> slip_work;  ///< [J]

  Side(Points& points, const Pair& pair, std::size_t side, const Box<Dim>& box)
      : of(points), kernel(pair.kernel), at_touch(pair.at_touch[side]), stiffness(pair.stiffness), cells(box, pair.kernel.range()) {
    for (std::size_t row = 0; row < of.ids.size(); ++row) {
      bool is_in = true;
      for (std::size_t d = 0; d < Dim; ++d) {
        const Real coordinate = of.position[row * Dim + d];
        is_in = is_in && coordinate >= box.lower[d] && coordinate <= box.upper[d];
      }
      if (is_in) rows.push_back(row);
    }
  }

  std::size_t count() const { return rows.size(); }

  template <class F>
  void for_each(F&& f) const {
    const std::size_t n = count();
    parallel_for(static_cast<Index>((n + k_piece - 1) / k_piece), static_cast<Index>(n), [&](Index piece) {
      const auto first = static_cast<std::size_t>(piece) * k_piece;
      for (std::size_t i = first; i < std::min(first + k_piece, n); ++i) f(i);
    });
  }
  template <class F>
  void for_each_near(std::size_t i, F&& f) const {
    const std::vector<Near>& all = near[i / k_piece];
    for (std::size_t k = begin[i]; k < end[i]; ++k) f(all[k].point, all[k].q);
  }

  /// Sorts the particles by cells, and by their rows in each.
  void sort() {
    std::vector<std::pair<Index, std::size_t>> order;
    for (const std::size_t row : rows) order.emplace_back(cells.key_of(cells.cell_of(of.row_of(of.position, row))), row);
    std::sort(order.begin(), order.end());
    const std::size_t n = count();
    keys.resize(n);
    x.resize(n);
    volume.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      keys[i] = order[i].first;
      rows[i] = order[i].second;
      x[i] = of.row_of(of.position, rows[i]);
      volume[i] = of.volumes[rows[i]];
    }
  }

  void find_near(const Side& other) {
    const std::size_t n = count();
    near.resize((n + k_piece - 1) / k_piece);
    begin.resize(n);
    end.resize(n);
    const Real factor = 1 / (kernel.range() * kernel.range());
    for_each([&](std::size_t i) {
      std::vector<Near>& all = near[i / k_piece];
      begin[i] = all.size();
      other.cells.for_each_row_near(x[i], [&](Index first, Index last) {
        auto j = static_cast<std::size_t>(std::lower_bound(other.keys.begin(), other.keys.end(), first) - other.keys.begin());
        for (; j < other.keys.size() && other.keys[j] <= last; ++j) {
          Real d2 = 0;
          for (std::size_t d = 0; d < Dim; ++d) d2 += (x[i][d] - other.x[j][d]) * (x[i][d] - other.x[j][d]);
          const Real q = 1 - d2 * factor;
          if (q > 0) all.push_back({static_cast<std::uint32_t>(j), q});
        }
      });
      end[i] = all.size();
    });
  }

  /// c and the pressure.
  void press(const Side& other) {
    c.resize(count());
    pressure.resize(count());
    energy.resize(count());
    for_each([&](std::size_t i) {
      Real sum = 0;
      for_each_near(i, [&](std::size_t j, Real q) { sum += other.volume[j] * kernel.value(q); });
      c[i] = sum;
      pressure[i] = 0;
      energy[i] = 0;
      if (sum == 0) return;
      const Real over = sum - at_touch[static_cast<std::size_t>(of.ids[rows[i]])];
      if (over <= 0) return;
      pressure[i] = stiffness * over;
      energy[i] = 0.5 * volume[i] * stiffness * over * over;
    });
  }

  void push(const Side& other) {
    force.resize(count());
    own_force.resize(count());
    for_each([&](std::size_t i) {
      Vec<Dim> all{};
      Vec<Dim> own{};
      for_each_near(i, [&](std::size_t j, Real q) {
        const Real both = pressure[i] + other.pressure[j];
        if (both == 0) return;
        const Real factor = volume[i] * other.volume[j] * kernel.slope(q);
        for (std::size_t d = 0; d < Dim; ++d) {
          const Real away = factor * (x[i][d] - other.x[j][d]);
          all[d] += both * away;
          own[d] += pressure[i] * away;
        }
      });
      force[i] = all;
      own_force[i] = own;
    });
  }

  /// The force of friction on each particle that presses, by its own share. `held`: ascending ids.
  void rub(const Side& other, const std::vector<Hold>& held, Real coefficient, Real dt) {
    // As stiff along the surface as across it, where a flat one begins to press.
    const Real w = kernel.over_plane(kernel.range() / (2 * k_range));
    friction.assign(count(), {});
    holds.assign(count(), {-1, {}, 0});
    slip_work.assign(count(), 0);
    for_each([&](std::size_t i) {
      const Real normal_force = std::sqrt(squared<Dim>(own_force[i]));
      if (normal_force == 0) return;
      Hold& hold = holds[i];
      hold.id = of.ids[rows[i]];
      const auto old = std::lower_bound(held.begin(), held.end(), hold.id, [](const Hold& one, Index id) { return one.id < id; });
      if (old != held.end() && old->id == hold.id) hold.pulled = old->pulled;
      // The spring turns with the surface and keeps its length.
      const Vec<Dim> normal = scaled<Dim>(own_force[i], 1 / normal_force);
      const Real before = std::sqrt(squared<Dim>(hold.pulled));
      hold.pulled = along<Dim>(hold.pulled, normal);
      const Real turned = std::sqrt(squared<Dim>(hold.pulled));
      if (turned > 0) hold.pulled = scaled<Dim>(hold.pulled, before / turned);
      const Vec<Dim> sliding = along<Dim>(velocity_past(other, i), normal);
      for (std::size_t d = 0; d < Dim; ++d) hold.pulled[d] += sliding[d] * dt;
      const Real k = stiffness * w * w * volume[i];
      const Real length = std::sqrt(squared<Dim>(hold.pulled));
      const Real longest = coefficient * normal_force / k;
      if (length > longest) {
        // All that the spring loses: it also gives way where the normal force falls.
        slip_work[i] = 0.5 * k * (length * length - longest * longest);
        hold.pulled = scaled<Dim>(hold.pulled, longest / length);
      }
      hold.energy = 0.5 * k * squared<Dim>(hold.pulled);
      friction[i] = scaled<Dim>(hold.pulled, -k);
    });
  }

  /// Velocity of a particle against the mean of its neighbours [m/s].
  Vec<Dim> velocity_past(const Side& other, std::size_t i) const {
    Vec<Dim> v = of.row_of(of.velocity, rows[i]);
    for_each_near(i, [&](std::size_t j, Real q) {
      const Real weight = other.volume[j] * kernel.value(q) / c[i];
      const Vec<Dim> v_j = other.of.row_of(other.of.velocity, other.rows[j]);
      for (std::size_t d = 0; d < Dim; ++d) v[d] -= weight * v_j[d];
    });
    return v;
  }

  /// What the friction of the other side's particles takes here.
  void take_friction(const Side& other) {
    for_each([&](std::size_t i) {
      for_each_near(i, [&](std::size_t j, Real q) {
        if (other.pressure[j] == 0) return;
        const Real weight = volume[i] * kernel.value(q) / other.c[j];
        for (std::size_t d = 0; d < Dim; ++d) force[i][d] -= weight * other.friction[j][d];
      });
      for (std::size_t d = 0; d < Dim; ++d) force[i][d] += friction[i][d];
    });
  }
};

template <int Dim>
PairContact<Dim>::~PairContact() = default;

template <int Dim>
PairContact<Dim>::PairContact(const Case& problem, std::vector<const Body<Dim>*> bodies) : friction_(problem.solver.friction) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Material& material = *problem.bodies[b].material;
    const Real speed = material.wave_speed(1);
    Points points;
    points.body = bodies[b];
    points.number = b;
    points.density = material.density();
    points.modulus = material.density() * speed * speed;
    points.read_constants();
    points.forces.assign(points.ids.size() * Dim, 0);
    points.spacing = std::pow(*std::max_element(points.volumes.begin(), points.volumes.end()), Real{1} / Dim);
    points_.push_back(std::move(points));
  }
  stable_dt_ = std::numeric_limits<Real>::infinity();
  for (std::size_t a = 0; a < points_.size(); ++a) {
    for (std::size_t b = a + 1; b < points_.size(); ++b) {
      const PairKernel<Dim> kernel(k_range * std::max(points_[a].spacing, points_[b].spacing));
      const Real stiffness = problem.solver.contact_stiffness * std::min(points_[a].modulus, points_[b].modulus);
      Pair pair{{a, b}, kernel, stiffness, {}, {}};
      for (std::size_t s : {0, 1}) {
        for (const Real volume : points_[pair.bodies[s]].volumes)
          pair.at_touch[s].push_back(kernel.beyond_plane(0.5 * std::pow(volume, Real{1} / Dim)));
      }
      pairs_.push_back(std::move(pair));
      // Layers of particles against each other have omega^2 = 2 K w^2 (1 / rho_a + 1 / rho_b), w the change of c per distance; half as
      // much again for the layers behind them and for c's curvature.
      const Real w = kernel.over_plane(0);
      const Real omega = std::sqrt(3 * stiffness * w * w * (1 / points_[a].density + 1 / points_[b].density));
      stable_dt_ = std::min(stable_dt_, 2 / omega);
    }
  }
}

template <int Dim>
const std::vector<Real>& PairContact<Dim>::forces(std::size_t body) const {
  static const std::vector<Real> none;
  return points_[body].forced.empty() ? none : points_[body].forces;
}

template <int Dim>
void PairContact<Dim>::update(Real dt) {
  dissipated_ = 0;
  // Two bodies move towards each other with the sum of their speeds. Particles move with the grid's velocities and not with their own;
  // the range of W, which is more than twice the distance of particles that touch, leaves room for that.
  Real speed = 0;
  for (const Points& points : points_) speed = std::max(speed, points.body->greatest_speed());
  free_way_ -= 2 * speed * dt;
  if (free_way_ > 0) return;
  energy_ = 0;
  for (Points& points : points_) points.read_places();
  free_way_ = std::numeric_limits<Real>::infinity();
  for (Pair& pair : pairs_) {
    const Real gap = gap_of<Dim>(points_[pair.bodies[0]].box, points_[pair.bodies[1]].box) - pair.kernel.range();
    free_way_ = std::min(free_way_, gap);
    meet(pair, dt);
  }
}

template <int Dim>
void PairContact<Dim>::meet(Pair& pair, Real dt) {
  Points& a = points_[pair.bodies[0]];
  Points& b = points_[pair.bodies[1]];
  const Real range = pair.kernel.range();
  if (gap_of<Dim>(a.box, b.box) >= range) {
    let_go(pair, {});
    return;
  }
  Box<Dim> box;
  for (std::size_t d = 0; d < Dim; ++d) {
    box.lower[d] = std::max(a.box.lower[d], b.box.lower[d]) - range;
    box.upper[d] = std::min(a.box.upper[d], b.box.upper[d]) + range;
  }
  Side sides[2] = {{a, pair, 0, box}, {b, pair, 1, box}};
  if (sides[0].count() == 0 || sides[1].count() == 0) {
    let_go(pair, {});
    return;
  }
  for (Side& side : sides) side.sort();
  for (int s : {0, 1}) sides[s].find_near(sides[1 - s]);
  for (int s : {0, 1}) sides[s].press(sides[1 - s]);
  for (int s : {0, 1}) sides[s].push(sides[1 - s]);
  if (friction_ > 0) rub(pair, sides, dt);
  for (const Side& side : sides) {
    for (const Real energy : side.energy) energy_ += energy;
    add_forces(side);
  }
}

template <int Dim>
void PairContact<Dim>::rub(Pair& pair, Side (&sides)[2], Real dt) {
  for (Side& side : sides) side.of.velocity = side.of.body->field("velocity", side.of.number).values;
  for (int s : {0, 1}) sides[s].rub(sides[1 - s], pair.holds[s], friction_, dt);
  for (int s : {0, 1}) sides[s].take_friction(sides[1 - s]);
  std::array<std::vector<Hold>, 2> holds;
  for (std::size_t s : {0, 1}) {
    for (const Real work : sides[s].slip_work) dissipated_ += work;
    for (const Hold& hold : sides[s].holds) {
      if (hold.id < 0) continue;
      holds[s].push_back(hold);
      energy_ += hold.energy;
    }
    std::sort(holds[s].begin(), holds[s].end(), [](const Hold& one, const Hold& other) { return one.id < other.id; });
  }
  let_go(pair, std::move(holds));
}

/// The springs of particles that no longer touch lose what they have stored.
template <int Dim>
void PairContact<Dim>::let_go(Pair& pair, std::array<std::vector<Hold>, 2> holds) {
  for (std::size_t s : {0, 1}) {
    auto next = holds[s].begin();
    for (const Hold& hold : pair.holds[s]) {
      while (next != holds[s].end() && next->id < hold.id) ++next;
      if (next == holds[s].end() || next->id != hold.id) dissipated_ += hold.energy;
    }
  }
  pair.holds = std::move(holds);
}

template <int Dim>
void PairContact<Dim>::add_forces(const Side& side) {
  Points& points = side.of;
  for (std::size_t i = 0; i < side.count(); ++i) {
    if (squared<Dim>(side.force[i]) == 0) continue;
    const Index id = points.ids[side.rows[i]];
    points.forced.push_back(id);
    for (std::size_t d = 0; d < Dim; ++d) points.forces[static_cast<std::size_t>(id) * Dim + d] += side.force[i][d];
  }
}

template class PairKernel<2>;
template class PairKernel<3>;
template class PairContact<2>;
template class PairContact<3>;

}  // namespace matpoint
