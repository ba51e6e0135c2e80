#include "body/particle_body.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "body/fill_body.hpp"
#include "core/parallel.hpp"

namespace matpoint {
namespace {

// Blocks that run empty are kept for a while: a particle may come back, and making a block costs more than sweeping an empty one.
constexpr int k_sweeps_between_prunes = 64;

// How far ahead of the sweep a block's header and its particles are fetched: the one must be there when the other is asked for.
constexpr std::size_t k_headers_ahead = 7;
constexpr std::size_t k_blocks_ahead = 3;

template <class T>
FetchRun run_of(const T& object) {
  const char* const begin = reinterpret_cast<const char*>(&object);
  return {begin, begin + sizeof object};
}

/// Which sweeps move particles, and what those map.
bool moves(Sweep what) { return what == Sweep::usl || what == Sweep::musl_gradient || what == Sweep::usf_velocity; }
bool updates_stress(Sweep what) { return what == Sweep::usl || what == Sweep::musl_gradient || what == Sweep::usf_stress; }
bool updates_velocity(Sweep what) { return what == Sweep::usl || what == Sweep::musl_velocity || what == Sweep::usf_velocity; }

/// What a sweep should fetch while it works other slots: `first` and the slots after it of a block that comes soon, the header of one
/// that comes later, and the upper rows of nodes (those below were used one row of blocks earlier).
template <int Dim, class R>
void set_fetch(Sweep what, SweepChunk<Dim, R>& chunk, const Block<Dim, R>& soon, const Block<Dim, R>& later, int first,
               const SlotLayout<Dim>& layout) {
  int count = 0;
  const int end = std::min(soon.slot_count, first + k_chunk_slots);
  // No sweep reads the ids, which are the last field; without a law x and v are enough, where nothing else is stored after F.
  const bool is_plain = layout.volume < 0 && layout.hoop < 0 && layout.C < 0 && layout.u < 0 && layout.b < 0;
  const int fields = updates_stress(what) || !is_plain ? layout.id : layout.F;
  for (int k = first; k < end; ++k) {
    const char* const begin = reinterpret_cast<const char*>(soon.slot(k));
    chunk.fetch[count++] = {begin, begin + static_cast<std::size_t>(fields * k_lanes<R>) * sizeof(R)};
  }
  if (first == 0) {
    for (int row = 1; row < k_rows_max<Dim> && soon.tiles[row][0] != nullptr; ++row) chunk.fetch[count++] = run_of(*soon.tiles[row][0]);
    chunk.fetch[count++] = run_of(later);
  }
  chunk.fetch_count = count;
}

template <int Dim>
SlotLayout<Dim> make_layout(const BodySpec& body, const ParticleScheme& scheme, bool has_volumes) {
  const Material& material = *body.material;
  SlotLayout<Dim> layout;
  int next = layout.F + Dim * Dim;
  if (scheme.transfer == Transfer::apic || scheme.transfer == Transfer::tpic) {
    layout.C = next;
    next += Dim * Dim;
  }
  if (body.formulation == Formulation::total) {
    layout.u = next;
    next += Dim;
  }
  if (scheme.has_body_force) {
    layout.b = next;
    next += Dim;
  }
  if (scheme.is_axisymmetric) layout.hoop = next++;
  if (has_volumes) layout.volume = next++;
  if (material.is_rate_dependent()) {
    layout.tau = next;
    next += k_stress_size<Dim>;
  }
  if (const int count = material.history_size(Dim); count > 0) {
    layout.history = next;
    layout.history_count = count;
    next += count;
  }
  layout.id = next++;  // what comes before is fetched in one run
  if (body.keeps_displacement && layout.u < 0) {
    layout.start = next;
    next += Dim;
  }
  layout.field_count = next;
  return layout;
}

}  // namespace

template <int Dim, class R>
ParticleBody<Dim, R>::ParticleBody(const BodySpec& spec, const ParticleScheme& scheme, Grid<Dim, R>& grid)
    : name_(spec.name), material_(spec.material), scheme_(scheme), grid_(grid), kernels_(kernel_table<Dim, R>()) {
  seed(spec, grid);
  reports_.resize(blocks_->bands().size());
  arrivals_.resize(blocks_->bands().size());
  measure_extremes();
}

template <int Dim, class R>
void ParticleBody<Dim, R>::seed(const BodySpec& spec, Grid<Dim, R>& grid) {
  Seeds seeds = fill_body(spec, seeding_grid(grid, scheme_.is_axisymmetric));
  const bool has_hoop_in_F = scheme_.is_axisymmetric && !spec.material->remembers_strain();
  const std::vector<InitialState> start = initial_states(spec, has_hoop_in_F ? 3 : Dim, seeds);
  const std::size_t n = seeds.position.size();
  id_count_ = static_cast<Index>(n);
  const Real area = std::accumulate(seeds.volume.begin(), seeds.volume.end(), Real{0});
  for (std::size_t p = 0; p < n && scheme_.is_axisymmetric; ++p) {
    if (seeds.position[p][0] == 0)
      throw InputError("{}: particle {} lies on the axis, where its ring has no mass; move it off x = 0", place_of(spec), p);
    seeds.volume[p] *= 2 * std::numbers::pi * seeds.position[p][0];  // of a full ring
  }
  const auto [smallest, largest] = std::minmax_element(seeds.volume.begin(), seeds.volume.end());
  smallest_volume_ = *smallest;
  uniform_volume_ = *smallest;
  const Real volume = std::accumulate(seeds.volume.begin(), seeds.volume.end(), Real{0});
  mass_ = volume * material_->density();
  Real per_cell = static_cast<Real>(n) / area;
  for (int d = 0; d < Dim; ++d) per_cell *= grid.cell_size(d);
  // The correction of fluids smooths the pressure without cells, on whose means water that stands starts to boil after some seconds.
  has_fbar_ = spec.has_fbar() && !(scheme_.is_corrected && spec.material->is_fluid());
  reach_ = 0.5 * std::min(Real{1}, std::pow(per_cell, -Real{1} / Dim));
  const SlotLayout<Dim> layout = make_layout<Dim>(spec, scheme_, *smallest != *largest);
  blocks_ = std::make_unique<Blocks>(grid, layout);

  std::vector<Place<Dim>> cells(n);
  std::vector<Vec<Dim>> places(n);
  for (std::size_t p = 0; p < n; ++p) {
    const Vec3& x = seeds.position[p];
    for (int d = 0; d < Dim; ++d) {
      const auto s = static_cast<std::size_t>(d);
      const Real place = (x[s] - grid.lower(d)) / grid.cell_size(d);
      cells[p][s] = std::min(static_cast<int>(place), grid.cells(d) - 1);  // points on the far side belong to the last cell
      places[p][s] = std::min(place - cells[p][s], Real{1});               // on the far side a division may round to more
    }
  }
  // Cell by cell, so that blocks and their slots lie in the order of the sweep.
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::lexicographical_compare(cells[a].rbegin(), cells[a].rend(), cells[b].rbegin(), cells[b].rend());
  });
  std::vector<R> fields(static_cast<std::size_t>(layout.field_count));
  // A law may have a stress where nothing is deformed.
  const std::array<Real, 6> tau =
      layout.tau >= 0 ? components_of(material_->kirchhoff_stress({1, 0, 0, 0, 1, 0, 0, 0, 1})) : std::array<Real, 6>{};
  for (const std::uint32_t p : order) {
    std::fill(fields.begin(), fields.end(), R{0});
    const Vec3 v = spec.velocity ? spec.velocity->at(seeds.position[p]) : Vec3{};
    const auto at = [&](int f) -> R& { return fields[static_cast<std::size_t>(f)]; };
    for (int d = 0; d < Dim; ++d) {
      const auto s = static_cast<std::size_t>(d);
      at(layout.x + d) = static_cast<R>(places[p][s]);
      at(layout.v + d) = static_cast<R>(v[s]);
      at(layout.F + d * Dim + d) = 1;
    }
    if (layout.hoop >= 0) at(layout.hoop) = 1;
    // The affine velocity that belongs to the field, from differences over half a cell: of a linear field, exactly.
    for (int c = 0; layout.C >= 0 && spec.velocity && c < Dim; ++c) {
      const Real step = 0.25 * grid.cell_size(c);
      Vec3 above = seeds.position[p];
      Vec3 below = above;
      above[static_cast<std::size_t>(c)] += step;
      below[static_cast<std::size_t>(c)] -= step;
      const Vec3 v_above = spec.velocity->at(above);
      const Vec3 v_below = spec.velocity->at(below);
      for (int d = 0; d < Dim; ++d) {
        const auto s = static_cast<std::size_t>(d);
        at(layout.C + d * Dim + c) = static_cast<R>((v_above[s] - v_below[s]) / (2 * step));
      }
    }
    at(layout.id) = id_to_bits<R>(p);
    for (int d = 0; layout.start >= 0 && d < Dim; ++d)
      at(layout.start + d) = static_cast<R>(seeds.position[p][static_cast<std::size_t>(d)] - grid.lower(d));
    if (layout.volume >= 0) at(layout.volume) = static_cast<R>(seeds.volume[p]);
    for (int s = 0; layout.tau >= 0 && s < k_stress_size<Dim>; ++s) at(layout.tau + s) = static_cast<R>(tau[static_cast<std::size_t>(s)]);
    if (!start.empty()) {
      const auto& [F, history] = start[p];
      for (int r = 0; r < Dim; ++r) {
        for (int c = 0; c < Dim; ++c) at(layout.F + r * Dim + c) = static_cast<R>(F[static_cast<std::size_t>(3 * r + c)]);
      }
      if (layout.hoop >= 0) at(layout.hoop) = static_cast<R>(F[8]);
      for (int h = 0; h < layout.history_count; ++h) at(layout.history + h) = static_cast<R>(history[static_cast<std::size_t>(h)]);
      const std::array<Real, 6> carried = components_of(material_->kirchhoff_stress(F, history));
      for (int s = 0; layout.tau >= 0 && s < k_stress_size<Dim>; ++s)
        at(layout.tau + s) = static_cast<R>(carried[static_cast<std::size_t>(s)]);
    }
    blocks_->insert(cells[p], fields.data());
  }
  blocks_->add_to_count(static_cast<Index>(n));
}

template <int Dim, class R>
SweepContext<Dim, R> ParticleBody<Dim, R>::make_context(Real dt, Real flip) const {
  Context context;
  context.layout = blocks_->layout();
  context.density = static_cast<R>(material_->density());
  context.uniform_volume = static_cast<R>(uniform_volume_);
  context.dt = dt;
  context.flip = static_cast<R>(flip);
  context.has_fbar = has_fbar_;
  context.is_affine_full = scheme_.transfer == Transfer::tpic;
  context.has_spin = spin_.is_used;
  for (int d = 0; d < Dim; ++d) {
    for (int c = 0; c < Dim; ++c) context.spin[d][c] = static_cast<R>(spin_.velocity_gradient[d][c]);
  }
  for (int d = 0; d < Dim; ++d) {
    context.inverse_cell_size[d] = static_cast<R>(1 / grid_.cell_size(d));
    context.cells[d] = grid_.cells(d);
    context.is_periodic[d] = grid_.is_periodic(d);
    context.reach[d] = static_cast<R>(reach_);
  }
  context.axis = static_cast<R>(-grid_.lower(0) / grid_.cell_size(0));
  context.law = material_->law_data();
  context.law_kernel = material_->law_index() >= 0 ? law_kernel<Dim, R>(material_->law_index()) : &collect_points;
  std::fill_n(context.J_min, k_lanes<R>, R{1});
  std::fill_n(context.J_max, k_lanes<R>, R{1});
  return context;
}

template <int Dim, class R>
SweepVariant ParticleBody<Dim, R>::variant() const {
  const SlotLayout<Dim>& at = blocks_->layout();
  if (scheme_.shape == ShapeKind::bspline3) return SweepVariant::bspline3;
  if (scheme_.shape == ShapeKind::gimp) return SweepVariant::gimp;
  if (scheme_.shape == ShapeKind::cpdi) return SweepVariant::cpdi;
  if (scheme_.shape == ShapeKind::bspline2) return SweepVariant::bspline2;
  return at.C >= 0 || at.u >= 0 || at.b >= 0 || at.hoop >= 0 || spin_.is_used ? SweepVariant::linear : SweepVariant::linear_plain;
}

template <int Dim, class R>
void ParticleBody<Dim, R>::sweep(Sweep what, Real dt, Real flip) {
  if (scheme_.is_co_rotating) {
    if (updates_velocity(what)) measure_spin(dt);
    if (what == Sweep::start || what == Sweep::start_momentum) measure_spin(0);
  }
  const Context context = make_context(dt, flip);
  const bool has_function = material_->law_index() < 0 && updates_stress(what);
  if (has_function) start_function_call();
  for_each_band([&](std::size_t b) {
    reports_[b].context = context;
    if (has_function) reports_[b].context.law = &call_;
    reports_[b].bad = {};
    reports_[b].moved = 0;
    sweep_band(what, b, reports_[b]);
  });
  collect(what, reports_);
  if (moves(what)) settle(what);
  if (has_function && bad_point_.id < 0) call_function(dt, context);
  if (!moves(what)) return;
  if (++sweeps_since_prune_ >= k_sweeps_between_prunes) {
    sweeps_since_prune_ = 0;
    for_each_band([&](std::size_t b) { blocks_->prune(blocks_->bands()[b]); });
  }
}

template <int Dim, class R>
void ParticleBody<Dim, R>::sweep_band(Sweep what, std::size_t band_index, BandReport& report) {
  Band& band = blocks_->bands()[band_index];
  const auto kernel = kernels_.sweeps[static_cast<int>(variant())][static_cast<int>(what)];
  blocks_->list_blocks(band);
  const std::vector<Block<Dim, R>*>& blocks = band.blocks;
  const std::size_t block_count = blocks.size();
  SweepChunk<Dim, R> chunk;
  std::vector<Mover<R>> movers;
  Waiting waiting;
  for (std::size_t n = 0; n < block_count; ++n) {
    Block<Dim, R>* const block = blocks[n];
    const Block<Dim, R>& soon = *blocks[std::min(n + k_blocks_ahead, block_count - 1)];
    const Block<Dim, R>& later = *blocks[std::min(n + k_headers_ahead, block_count - 1)];
    if (n > 0) insert_waiting(what, waiting, band, *blocks[n - 1], *block);
    std::copy_n(block->first.begin(), Dim, chunk.cell);
    for (int row = 0; row < grid_.row_count(); ++row) {
      for (int next = 0; next < 2; ++next) {
        grid_.prepare(*block->tiles[row][next], band_index);
        chunk.nodes[row][next] = &block->tiles[row][next]->values;
      }
    }
    if (block->slot_count == 0) continue;
    movers.clear();
    for (int first = 0; first < block->slot_count; first += k_chunk_slots) {
      chunk.slot_count = std::min(k_chunk_slots, block->slot_count - first);
      for (int k = 0; k < chunk.slot_count; ++k) chunk.slots[k] = block->slot(first + k);
      set_fetch(what, chunk, soon, later, first, blocks_->layout());
      for (int lane = 0; lane < k_lanes<R>; ++lane) chunk.counts[lane] = block->counts[lane] - static_cast<R>(first);
      kernel(report.context, chunk);
      for (int m = 0; m < chunk.mover_count; ++m) {
        movers.push_back(chunk.movers[m]);
        movers.back().slot += first;
      }
      if (chunk.bad_slot >= 0 && report.bad.id < 0) {
        const R* const fields = chunk.slots[chunk.bad_slot] + chunk.bad_lane;
        const Vec3 place = blocks_->position(*block, fields, chunk.bad_lane);
        const Particle particle{fields, k_lanes<R>, position_of(fields, k_lanes<R>, place)};
        report.bad = {id(particle), particle.position, J(particle)};
      }
    }
    if (movers.empty()) continue;
    report.moved += static_cast<Index>(movers.size());
    const std::size_t begin = band.leaving.count();
    blocks_->extract(band, *block, movers);
    insert_near(what, waiting, band, *block, begin);
  }
  if (block_count > 0) {
    insert_swept(what, waiting.plane, band, *blocks.back());
    insert_swept(what, waiting.row, band, *blocks.back());
  }
  // Those that are left go to blocks that do not exist yet.
  for (const MovingParticles<Dim, R>* list : {&waiting.row, &waiting.plane}) {
    for (std::size_t i = 0; i < list->count(); ++i)
      band.leaving.push(list->particle(i, blocks_->stride()), blocks_->stride(), list->targets[i]);
  }
}

/// Of the particles that have just left `block`, from `begin` on: those into blocks that this sweep has passed are inserted while the
/// blocks are still in the caches, those into later blocks of the band wait; the others stay in the list, for settle().
template <int Dim, class R>
void ParticleBody<Dim, R>::insert_near(Sweep what, Waiting& waiting, Band& band, const Block<Dim, R>& block, std::size_t begin) {
  const int stride = blocks_->stride();
  const int own_band = blocks_->band_of(block.first);
  band.leaving.keep_if(begin, stride, [&](std::size_t i) {
    const auto& target = band.leaving.targets[i];
    if (target.is_outside || blocks_->band_of(target.cell) != own_band) return true;
    const R* const fields = band.leaving.particle(i, stride);
    if (insert_if_swept(what, band, block, target.cell, fields)) return false;
    const bool is_in_plane = Dim == 2 || target.cell[Dim - 1] <= block.first[Dim - 1];
    (is_in_plane ? waiting.row : waiting.plane).push(fields, stride, target);
    return false;
  });
}

/// Between two blocks of a sweep: at the end of a row and of a plane the particles that wait for that.
template <int Dim, class R>
void ParticleBody<Dim, R>::insert_waiting(Sweep what, Waiting& waiting, Band& band, const Block<Dim, R>& last, const Block<Dim, R>& next) {
  if (next.first[1] == last.first[1] && next.first[Dim - 1] == last.first[Dim - 1]) return;
  if (Dim == 3 && next.first[Dim - 1] != last.first[Dim - 1]) insert_swept(what, waiting.plane, band, last);
  insert_swept(what, waiting.row, band, last);
}

template <int Dim, class R>
void ParticleBody<Dim, R>::insert_swept(Sweep what, MovingParticles<Dim, R>& list, Band& band, const Block<Dim, R>& last) {
  const int stride = blocks_->stride();
  list.keep_if(0, stride,
               [&](std::size_t i) { return !insert_if_swept(what, band, last, list.targets[i].cell, list.particle(i, stride)); });
}

/// Inserts a particle of this band, if its block exists and is not after `last`, the last block that was swept.
template <int Dim, class R>
bool ParticleBody<Dim, R>::insert_if_swept(Sweep what, Band& band, const Block<Dim, R>& last, const Place<Dim>& cell, const R* fields) {
  Block<Dim, R>* const block = blocks_->find(cell);
  if (block == nullptr || block->key > last.key) return false;
  const int lane = cell[0] % k_lanes<R>;
  blocks_->insert(band, *block, lane, fields);
  map_arrival(what, *block, lane, fields);
  return true;
}

template <int Dim, class R>
void ParticleBody<Dim, R>::collect(Sweep what, const std::vector<BandReport>& reports) {
  // In the order of the bands: the same bits for any number of threads.
  if (updates_velocity(what)) {
    for (int d = 0; d < Dim; ++d) {
      speed_max_[d] = 0;
      for (const BandReport& report : reports) {
        for (const R speed : report.context.speed_max[d]) speed_max_[d] = std::max(speed_max_[d], static_cast<Real>(speed));
      }
    }
  }
  if (moves(what)) {
    moved_ = 0;
    for (const BandReport& report : reports) moved_ += report.moved;
  }
  if (!updates_stress(what)) return;
  dissipated_ = 0;
  bad_point_ = {};
  J_min_ = J_max_ = 1;
  wave_modulus_ = 0;
  for (const BandReport& report : reports) {
    dissipated_ += report.context.dissipated;
    if (bad_point_.id < 0) bad_point_ = report.bad;
    for (const R J : report.context.J_min) J_min_ = std::min(J_min_, static_cast<Real>(J));
    for (const R J : report.context.J_max) J_max_ = std::max(J_max_, static_cast<Real>(J));
    for (const R modulus : report.context.wave_modulus) wave_modulus_ = std::max(wave_modulus_, static_cast<Real>(modulus));
  }
}

template <int Dim, class R>
void ParticleBody<Dim, R>::settle(Sweep what) {
  std::vector<Band>& bands = blocks_->bands();
  for (auto& arrivals : arrivals_) arrivals.clear();
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const MovingParticles<Dim, R>& leaving = bands[b].leaving;
    for (std::size_t i = 0; i < leaving.count(); ++i) {
      if (leaving.targets[i].is_outside)
        keep_outside(leaving, i);
      else
        arrivals_[static_cast<std::size_t>(grid_.band_of(leaving.targets[i].cell[Dim - 1]))].emplace_back(b, i);
    }
  }
  for_each_band([&](std::size_t b) { settle_band(what, b, arrivals_[b]); });
  for (Band& band : bands) band.leaving.clear();
}

template <int Dim, class R>
void ParticleBody<Dim, R>::settle_band(Sweep what, std::size_t band, const std::vector<std::pair<std::size_t, std::size_t>>& arrivals) {
  for (const auto& [source, i] : arrivals) {
    const MovingParticles<Dim, R>& leaving = blocks_->bands()[source].leaving;
    const R* const fields = leaving.particle(i, blocks_->stride());
    const auto [block, lane] = blocks_->insert(leaving.targets[i].cell, fields);
    for (int row = 0; row < grid_.row_count(); ++row) {
      for (Tile<Dim, R>* tile : block->tiles[row]) grid_.prepare(*tile, band);
    }
    map_arrival(what, *block, lane, fields);
  }
}

/// What the kernels do for the particles that stay: mass, momentum and force to the nodes of the cell.
template <int Dim, class R>
void ParticleBody<Dim, R>::map_arrival(Sweep what, const Block<Dim, R>& block, int lane, const R* fields) {
  switch (scheme_.shape) {
    case ShapeKind::linear: return map_arrival_with<ShapeLinear<R>>(what, block, lane, fields);
    case ShapeKind::bspline2: return map_arrival_with<ShapeBSpline2<R>>(what, block, lane, fields);
    case ShapeKind::bspline3: return map_arrival_with<ShapeBSpline3<R>>(what, block, lane, fields);
    case ShapeKind::gimp: return map_arrival_with<ShapeGimp<R>>(what, block, lane, fields);
    case ShapeKind::cpdi: return map_arrival_with<ShapeConvected<R>>(what, block, lane, fields);
  }
}

template <int Dim, class R>
template <class Shape>
void ParticleBody<Dim, R>::map_arrival_with(Sweep what, const Block<Dim, R>& block, int lane, const R* fields) {
  constexpr int n = Shape::k_nodes;
  const SlotLayout<Dim>& at = blocks_->layout();
  const R* const tau = fields + at.field_count;
  const R volume = at.volume >= 0 ? fields[at.volume] : static_cast<R>(uniform_volume_);
  const R m = volume * static_cast<R>(material_->density());
  const auto weights = weights_of<Shape>(block, lane, fields, 1);
  Shape shapes[Dim];
  for (int d = 0; d < Dim; ++d) shapes[d] = shape_at<Shape>(block.first[static_cast<std::size_t>(d)] + (d == 0 ? lane : 0), d);
  for (int row = 0; row < grid_.row_count(); ++row) {
    R N[n], dN[Dim][n];
    weights.of_row(row, N, dN);
    for (int i = 0; i < n; ++i) {
      const int index[3] = {i, row % n, row / n};
      NodeValues<Dim, R>& nodes = block.tiles[row][(lane + i) / k_lanes<R>]->values;
      const int node = (lane + i) % k_lanes<R>;
      nodes.mass[node] += N[i] * m;
      for (int d = 0; d < Dim; ++d) {
        R v = fields[at.v + d];
        for (int c = 0; (at.C >= 0 || spin_.is_used) && c < Dim; ++c)
          v += (at.C >= 0 ? fields[at.C + d * Dim + c] : static_cast<R>(spin_.velocity_gradient[d][c])) *
               (shapes[c].place(index[c]) - weights.centre(c)) * static_cast<R>(grid_.cell_size(c));
        nodes.momentum[d][node] += N[i] * m * v;
      }
      if (what == Sweep::usf_velocity) continue;
      for (int c = 0; c < Dim; ++c) {
        R sum = 0;
        for (int d = 0; d < Dim; ++d) sum += tau[stress_index(c, d)] * dN[d][i] / static_cast<R>(grid_.cell_size(d));
        nodes.force[c][node] -= volume * sum;
        if (at.b >= 0) nodes.force[c][node] += N[i] * m * fields[at.b + c];
        if (at.hoop >= 0 && c == 0) {
          const Real r = grid_.lower(0) + (block.first[0] + lane + static_cast<Real>(fields[at.x])) * grid_.cell_size(0);
          nodes.force[0][node] -= volume * tau[2] * N[i] / static_cast<R>(r);
        }
      }
    }
  }
}

template <int Dim, class R>
void ParticleBody<Dim, R>::keep_outside(const MovingParticles<Dim, R>& leaving, std::size_t i) {
  const SlotLayout<Dim>& at = blocks_->layout();
  const R* const fields = leaving.particle(i, blocks_->stride());
  Outside outside{std::vector<R>(fields, fields + at.field_count), {}};
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    outside.position[s] = grid_.lower(d) + (leaving.targets[i].cell[s] + static_cast<Real>(fields[at.x + d])) * grid_.cell_size(d);
  }
  mass_ -= volume0(particle_of(outside)) * material_->density();
  blocks_->add_to_count(-1);
  outside_.push_back(std::move(outside));
}

template <int Dim, class R>
void ParticleBody<Dim, R>::append_escapes(std::size_t body, std::vector<Escape>& escapes) const {
  for (const Outside& outside : outside_) {
    const Particle p = particle_of(outside);
    escapes.push_back({body, id(p), p.position, velocity(p)});
  }
}

template <int Dim, class R>
void ParticleBody<Dim, R>::remove_escaped(const Vec3& gravity, Ledger& ledger) {
  for (const Outside& outside : outside_) {
    const BodyTotals lost = totals_of(particle_of(outside), gravity);
    ++ledger.removed_count;
    ledger.removed_mass += lost.mass;
    ledger.removed_energy += lost.kinetic_energy + lost.strain_energy + lost.gravitational_energy;
    for (std::size_t d = 0; d < 3; ++d) ledger.removed_momentum[d] += lost.momentum[d];
  }
  outside_.clear();
}

template <int Dim, class R>
Real ParticleBody<Dim, R>::stable_dt() const {
  Real dt = std::numeric_limits<Real>::infinity();
  for (const Real J : {J_min_, Real{1}, J_max_}) {
    // Waves cross the reference configuration faster where it is compressed, at most by 1 / J.
    const Real shortening = blocks_->layout().u >= 0 ? std::min(J, Real{1}) : Real{1};
    const Real wave_speed = std::max(material_->wave_speed(J), std::sqrt(wave_modulus_ / material_->density())) / shortening;
    const Real viscosity = material_->kinematic_viscosity(J);
    for (int d = 0; d < Dim; ++d) {
      const Real h = grid_.cell_size(d);
      dt = std::min(dt, h / (wave_speed + speed_max_[d]));
      if (viscosity > 0) dt = std::min(dt, h * h / (2 * Dim * viscosity));
    }
  }
  return dt;
}

template <int Dim, class R>
Occupancy ParticleBody<Dim, R>::occupancy() const {
  return {blocks_->lane_count(), moved_, blocks_->count() * blocks_->layout().field_count * static_cast<Index>(sizeof(R))};
}

template class ParticleBody<2, double>;
template class ParticleBody<3, double>;
template class ParticleBody<2, float>;
template class ParticleBody<3, float>;

}  // namespace matpoint
