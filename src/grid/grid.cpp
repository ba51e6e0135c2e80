#include "grid/grid.hpp"

#include <algorithm>

#include "core/parallel.hpp"
#include "grid/boundary_condition.hpp"

namespace matpoint {
namespace {

// Thick bands share few rows with their neighbours, many bands keep all threads busy to the end.
constexpr int k_bands_wanted = 64;
constexpr int k_band_rows_max = 16;

}  // namespace

template <int Dim, class R>
Grid<Dim, R>::Grid(const GridSpec& spec, ShapeKind shape) : shape_(shape), span_(span_of(shape)) {
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    lower_[d] = spec.lower[s];
    upper_[d] = spec.upper[s];
    cells_[d] = spec.cells[s];
    cell_size_[d] = (spec.upper[s] - spec.lower[s]) / spec.cells[s];
    const std::string axis(1, "xyz"[d]);
    is_periodic_[d] = std::find(spec.periodic.begin(), spec.periodic.end(), axis) != spec.periodic.end();
    has_periodic_ = has_periodic_ || is_periodic_[d];
  }
  const int rows = cells_[Dim - 1];
  // A band may reach into the next one only.
  band_rows_ = std::clamp(rows / k_bands_wanted, span_, k_band_rows_max);
  bands_.resize(static_cast<std::size_t>((rows + band_rows_ - 1) / band_rows_));
}

template <int Dim, class R>
Grid<Dim, R>::~Grid() {
  for (Band& band : bands_) {
    for (TileType* tile : band.tiles) tile->~TileType();
    for (TileType* tile : band.unused) tile->~TileType();
  }
}

template <int Dim, class R>
GridGeometry Grid<Dim, R>::geometry() const {
  GridGeometry geometry;
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    geometry.lower[s] = lower_[d];
    geometry.cell_size[s] = cell_size_[d];
    geometry.nodes[s] = nodes(d);
  }
  return geometry;
}

template <int Dim, class R>
Index Grid<Dim, R>::node_count() const {
  Index count = 1;
  for (int d = 0; d < Dim; ++d) count *= nodes(d);
  return count;
}

template <int Dim, class R>
Vec<Dim> Grid<Dim, R>::node_position(const Place<Dim>& node) const {
  Vec<Dim> position;
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    const int i = node[s];
    // Beyond periodic sides cells and knots go on.
    Real place = i - 0.5 * (span_ - 1);
    if (!has_domains(shape_) && !is_periodic_[d]) {
      // The mean of as many knots as the degree of the splines; linear shapes are splines of degree 1.
      place = 0;
      for (int k = 0; k < span_; ++k) place += static_cast<Real>(std::clamp(i - k, 0, cells_[d])) / span_;
    }
    // The far side exactly, so that `side = "top"` and a region that ends there mean the same nodes.
    const bool is_on_far_side = is_periodic_[d] ? place == cells_[d] : i == side_node(d, true);
    position[s] = is_on_far_side ? upper_[d] : lower_[d] + place * cell_size_[d];
  }
  return position;
}

template <int Dim, class R>
std::vector<Real> Grid<Dim, R>::node_positions() const {
  std::vector<Real> all;
  all.reserve(static_cast<std::size_t>(node_count()) * Dim);
  Place<Dim> node{};
  for (Index n = 0; n < node_count(); ++n) {
    Vec<Dim> x = node_position(node);
    for (int d = 0; d < Dim; ++d) {
      const auto s = static_cast<std::size_t>(d);
      const bool is_in_grid = x[s] >= lower_[d] && x[s] < upper_[d];
      Place<Dim> image = node;
      image[s] = image_of(node[s], d);
      if (!is_in_grid && image[s] >= 0) x[s] = node_position(image)[s];
    }
    all.insert(all.end(), x.begin(), x.end());
    for (std::size_t d = 0; d < Dim && ++node[d] == nodes(static_cast<int>(d)); ++d) node[d] = 0;
  }
  return all;
}

template <int Dim, class R>
Index Grid<Dim, R>::key_of(const Place<Dim>& node) const {
  Index key = 0;
  for (int d = Dim - 1; d >= 0; --d) key = key * (nodes(d) + 2 * k_lanes<R>)+node[static_cast<std::size_t>(d)];
  return key;
}

template <int Dim, class R>
void Grid<Dim, R>::set_up(TileType& tile, const Place<Dim>& node) const {
  tile.values = NodeValues<Dim, R>{};
  tile.first = node;
  tile.key = key_of(node);
  tile.pass = pass_count_;  // there is nothing on it to work
  tile.user_count = 0;
  tile.components.clear();
  tile.normals.clear();
  tile.contacts.clear();
  tile.has_images = false;
  for (int lane = 0; lane < k_lanes<R>; ++lane) {
    Place<Dim> here = node;
    here[0] += lane;
    tile.booked[lane] = 1;
    for (int d = 0; d < Dim; ++d) {
      const int i = here[static_cast<std::size_t>(d)];
      if (image_of(i, d) < 0) continue;
      tile.has_images = true;
      if (i >= cells_[d]) tile.booked[lane] = 0;
    }
    if (here[0] < nodes(0) && conditions_ != nullptr) conditions_->append(*this, here, lane, tile);
  }
}

template <int Dim, class R>
Tile<Dim, R>* Grid<Dim, R>::make_tile(Band& band, const Place<Dim>& node) {
  TileType* tile = nullptr;
  if (band.unused.empty()) {
    tile = new (tiles_.take(sizeof(TileType))) TileType;
  } else {
    tile = band.unused.back();
    band.unused.pop_back();
  }
  set_up(*tile, node);
  band.tiles.push_back(tile);
  return tile;
}

template <int Dim, class R>
Tile<Dim, R>* Grid<Dim, R>::acquire(const Place<Dim>& node) {
  Band& band = bands_[static_cast<std::size_t>(band_of_node_row(node[Dim - 1]))];
  TileType*& tile = band.by_key[key_of(node)];
  if (tile == nullptr) {
    TileType* const made = tile = make_tile(band, node);  // the map may move when twins are made
    ++made->user_count;
    // The tiles on the other side of a periodic direction are needed as long as this one, so for good.
    for (int d = 0; d < Dim && made->has_images; ++d) {
      for (const Place<Dim>& twin : image_tiles(node, d)) {
        ++made->user_count;
        if (find(twin) == nullptr) acquire(twin);
      }
    }
    return made;
  }
  ++tile->user_count;
  return tile;
}

template <int Dim, class R>
void Grid<Dim, R>::release(TileType* tile) {
  if (--tile->user_count > 0) return;
  Band& band = bands_[static_cast<std::size_t>(band_of_node_row(tile->first[Dim - 1]))];
  band.by_key.erase(tile->key);
  band.tiles.erase(std::find(band.tiles.begin(), band.tiles.end(), tile));
  band.unused.push_back(tile);
}

template <int Dim, class R>
Tile<Dim, R>* Grid<Dim, R>::find(const Place<Dim>& node) const {
  const Band& band = bands_[static_cast<std::size_t>(band_of_node_row(node[Dim - 1]))];
  const auto found = band.by_key.find(key_of(node));
  return found == band.by_key.end() ? nullptr : found->second;
}

template <int Dim, class R>
template <class F>
void Grid<Dim, R>::for_each_band(F&& f) {
  Index work = 0;
  for (const Band& band : bands_) work += static_cast<Index>(band.tiles.size()) * k_lanes<R>;
  parallel_for(band_count(), work, [&](Index b) { f(static_cast<std::size_t>(b)); });
}

template <int Dim, class R>
std::vector<Place<Dim>> Grid<Dim, R>::image_tiles(const Place<Dim>& first, int d) const {
  const auto s = static_cast<std::size_t>(d);
  std::vector<Place<Dim>> all;
  for (int lane = 0; lane < (d == 0 ? k_lanes<R> : 1); ++lane) {
    Place<Dim> image = first;
    image[s] = image_of(first[s] + lane, d);
    if (image[s] < 0) continue;
    if (d == 0) image[0] -= image[0] % k_lanes<R>;
    if (all.empty() || all.back() != image) all.push_back(image);
  }
  return all;
}

template <int Dim, class R>
void Grid<Dim, R>::fold_periodic(Fold what) {
  if (!has_periodic_) return;
  // A node and its image are one: both get the sum, and everything after treats them alike.
  const auto fold = [](R& a, R& b) { a = b = a + b; };
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    for (Band& band : bands_) {
      for (TileType* tile : band.tiles) {
        if (!is_periodic_[d] || !tile->has_images || tile->first[s] >= span_) continue;
        for (int lane = 0; lane < (d == 0 ? span_ : k_lanes<R>); ++lane) {
          Place<Dim> place = tile->first;
          place[s] = image_of(d == 0 ? lane : place[s], d);
          const int far_lane = d == 0 ? place[0] % k_lanes<R> : lane;
          if (d == 0) place[0] -= far_lane;
          NodeValues<Dim, R>& near = tile->values;
          NodeValues<Dim, R>& far = find(place)->values;
          if (what == Fold::all) fold(near.mass[lane], far.mass[far_lane]);
          for (int c = 0; c < Dim; ++c) {
            if (what != Fold::force) fold(near.momentum[c][lane], far.momentum[c][far_lane]);
            if (what != Fold::momentum) fold(near.force[c][lane], far.force[c][far_lane]);
          }
        }
      }
    }
  }
}

template <int Dim, class R>
void Grid<Dim, R>::start_pass(NodePass pass, const KernelTable<Dim, R>& kernels, const NodalDynamics<Dim>& dynamics, Real t, Real dt) {
  pass_ = pass;
  ++pass_count_;
  kernels_ = &kernels;
  dynamics_ = dynamics;
  dt_ = dt;
  boundary_velocities_ = conditions_->velocities(t);
  if (pass == NodePass::advance || pass == NodePass::advance_keep) {
    // A function of time need not know a time before the start, which rounding may ask for.
    boundary_velocities_before_ = conditions_->velocities(std::max(Real{0}, t - dt));
  }
  sums_.assign(bands_.size(), {});
  books_.assign(bands_.size(), {});
}

template <int Dim, class R>
void Grid<Dim, R>::work_tile(TileType& tile, std::size_t band) {
  tile.pass = pass_count_;
  const bool is_constrained = !tile.components.empty() || !tile.normals.empty() || !tile.contacts.empty();
  if (pass_ == NodePass::advance || pass_ == NodePass::advance_keep) {
    if (body_force_ != nullptr) add_body_force(tile);
    kernels_->advance(tile.values, dynamics_, dt_, tile.booked, sums_[band]);
    if (is_constrained)
      conditions_->constrain(*this, tile, dynamics_, boundary_velocities_, boundary_velocities_before_, dt_, books_[band]);
    if (body_force_ != nullptr) book_body_force(tile, books_[band]);
    for (int d = 0; d < Dim && is_refined_; ++d) std::copy_n(tile.values.velocity[d], k_lanes<R>, tile.values.second[d]);
  } else if (pass_ == NodePass::refine) {
    refine(tile, books_[band]);
  } else {
    kernels_->map_velocity(tile.values, dynamics_);
    if (is_constrained) conditions_->constrain_second(*this, tile, boundary_velocities_);
  }
  if (pass_ != NodePass::velocity_keep) kernels_->clear(tile.values, pass_ == NodePass::advance_keep || pass_ == NodePass::refine);
}

/// The next term of the series for the velocity: v_j+1 = v_j - S+ S v_j, of which the momentum holds m S+ S v_j (Nairn & Hammerquist 2021,
/// with conditions by leaving out what they forbid). The sum of m v_j+1 over all nodes is zero; what is left out is booked.
template <int Dim, class R>
void Grid<Dim, R>::refine(TileType& tile, Ledger& books) const {
  NodeValues<Dim, R>& nodes = tile.values;
  Vec<Dim> terms[k_lanes<R>];
  Vec<Dim> allowed[k_lanes<R>];
  for (int lane = 0; lane < k_lanes<R>; ++lane) {
    const Real m = nodes.moved_mass[lane];
    const bool is_active = m > 0 && m >= dynamics_.mass_cutoff;
    for (int d = 0; d < Dim; ++d) {
      const auto s = static_cast<std::size_t>(d);
      const Real momentum = nodes.momentum[d][lane];
      terms[lane][s] = is_active ? nodes.second[d][lane] - momentum / m : 0;
      if (!is_active && tile.booked[lane] > 0) books.cutoff_impulse[s] += momentum;
    }
    allowed[lane] = terms[lane];
  }
  BoundaryConditions<Dim, R>::leave_out(tile, allowed);
  for (int lane = 0; lane < k_lanes<R>; ++lane) {
    for (int d = 0; d < Dim; ++d) {
      const auto s = static_cast<std::size_t>(d);
      nodes.velocity[d][lane] += static_cast<R>(allowed[lane][s]);
      nodes.second[d][lane] = static_cast<R>(allowed[lane][s]);
      const Real held = allowed[lane][s] - terms[lane][s];
      if (tile.booked[lane] > 0 && held != 0)
        books.press(BoundaryConditions<Dim, R>::condition_of(tile, lane, d), s, nodes.moved_mass[lane] * held, 0);
    }
  }
}

template <int Dim, class R>
template <class F>
void Grid<Dim, R>::for_each_node(const TileType& tile, F&& f) const {
  std::size_t node = 0;
  for (int d = Dim - 1; d >= 0; --d)
    node = node * static_cast<std::size_t>(nodes(d)) + static_cast<std::size_t>(tile.first[static_cast<std::size_t>(d)]);
  for (int lane = 0; lane < k_lanes<R> && tile.first[0] + lane < nodes(0); ++lane) f(lane, node++);
}

template <int Dim, class R>
void Grid<Dim, R>::copy_periodic(std::vector<Real>& values) const {
  std::size_t stride = Dim;
  for (int d = 0; d < Dim; ++d) {
    const auto count = static_cast<std::size_t>(nodes(d));
    const auto cells = static_cast<std::size_t>(cells_[d]);
    for (std::size_t i = 0; is_periodic_[d] && i < values.size(); ++i) {
      if (i / stride % count >= cells) values[i] = values[i - cells * stride];
    }
    stride *= count;
  }
}

template <int Dim, class R>
void Grid<Dim, R>::add_body_force(TileType& tile) const {
  for_each_node(tile, [&](int lane, std::size_t node) {
    for (std::size_t d = 0; d < Dim; ++d)
      tile.values.force[d][lane] += tile.values.mass[lane] * static_cast<R>((*body_force_)[node * Dim + d]);
  });
}

/// Impulse and work of the body force in this step; nodes under the mass cutoff have their share in the cutoff's books.
template <int Dim, class R>
void Grid<Dim, R>::book_body_force(const TileType& tile, Ledger& books) const {
  for_each_node(tile, [&](int lane, std::size_t node) {
    const Real m = tile.values.mass[lane] * tile.booked[lane];
    for (std::size_t d = 0; d < Dim; ++d) {
      const Real impulse = m * (*body_force_)[node * Dim + d] * dt_;
      books.body_force_impulse[d] += impulse;
      // With the velocity in the middle of the step.
      books.body_force_work += impulse * (tile.values.velocity[d][lane] - 0.5 * dt_ * tile.values.second[d][lane]);
    }
  });
}

template <int Dim, class R>
void Grid<Dim, R>::finish_pass(Ledger& ledger) {
  for_each_band([&](std::size_t b) {
    for (TileType* tile : bands_[b].tiles) prepare(*tile, b);
  });
  // In the order of the bands: the same bits for any number of threads.
  for (std::size_t b = 0; b < bands_.size(); ++b) {
    ledger.damping_dissipation += sums_[b].damping_dissipation + books_[b].damping_dissipation;
    ledger.add_boundaries(books_[b]);
    ledger.contact_dissipation += books_[b].contact_dissipation;
    ledger.body_force_work += books_[b].body_force_work;
    for (std::size_t d = 0; d < Dim; ++d) {
      ledger.damping_impulse[d] += sums_[b].damping_impulse[d] + books_[b].damping_impulse[d];
      ledger.cutoff_impulse[d] += sums_[b].cutoff_impulse[d];
      ledger.cutoff_impulse[d] += books_[b].cutoff_impulse[d];
      ledger.body_force_impulse[d] += books_[b].body_force_impulse[d];
    }
  }
}

template <int Dim, class R>
void Grid<Dim, R>::clear() {
  for_each_band([&](std::size_t b) {
    for (TileType* tile : bands_[b].tiles) tile->values = NodeValues<Dim, R>{};
  });
}

template <int Dim, class R>
void Grid<Dim, R>::remove_tiles() {
  for (Band& band : bands_) {
    band.unused.insert(band.unused.end(), band.tiles.begin(), band.tiles.end());
    band.tiles.clear();
    band.by_key.clear();
  }
}

template <int Dim, class R>
void Grid<Dim, R>::declare_state(State& state) {
  // The order of the tiles is that in which their books are added.
  std::vector<Place<Dim>> firsts;
  std::vector<int> users;
  for (const Band& band : bands_) {
    for (const TileType* tile : band.tiles) {
      firsts.push_back(tile->first);
      users.push_back(tile->user_count);
    }
  }
  if (state.is_loading()) {
    firsts.clear();
    users.clear();
  }
  state.add("tile_first_node", firsts);
  state.add("tile_users", users);
  std::vector<TileType*> tiles;
  if (!state.is_loading()) {
    for (const Band& band : bands_) tiles.insert(tiles.end(), band.tiles.begin(), band.tiles.end());
  } else {
    if (users.size() != firsts.size()) state.fail("tile_users", "has not one number for each tile");
    std::vector<std::vector<TileType*>> ordered(bands_.size());
    for (std::size_t k = 0; k < firsts.size(); ++k) {
      const Place<Dim>& node = firsts[k];
      for (std::size_t d = 0; d < Dim; ++d) {
        if (node[d] < 0 || node[d] >= nodes(static_cast<int>(d)) + (d == 0 ? 2 * k_lanes<R> : 0) || (d == 0 && node[d] % k_lanes<R> != 0))
          state.fail("tile_first_node", fmt::format("has a node ({}) that the grid does not have", fmt::join(node, ", ")));
      }
      const auto b = static_cast<std::size_t>(band_of_node_row(node[Dim - 1]));
      TileType*& tile = bands_[b].by_key[key_of(node)];
      if (tile == nullptr) tile = make_tile(bands_[b], node);
      tile->user_count = users[k];
      ordered[b].push_back(tile);
      tiles.push_back(tile);
    }
    for (std::size_t b = 0; b < bands_.size(); ++b) {
      if (ordered[b].size() != bands_[b].tiles.size()) state.fail("tile_first_node", "has not the nodes around all particles");
      bands_[b].tiles = std::move(ordered[b]);
    }
  }
  using Lanes = std::array<R, k_lanes<R>>;
  const auto add = [&](const std::string& name, auto&& lanes_of) {
    std::vector<Lanes> all(state.is_loading() ? 0 : tiles.size());
    for (std::size_t k = 0; k < all.size(); ++k) std::copy_n(lanes_of(tiles[k]->values), k_lanes<R>, all[k].data());
    state.add(name, all);
    if (all.size() != tiles.size()) state.fail(name, fmt::format("has {} rows, not {}", all.size(), tiles.size()));
    for (std::size_t k = 0; k < all.size(); ++k) std::copy_n(all[k].data(), k_lanes<R>, lanes_of(tiles[k]->values));
  };
  add("mass", [](NodeValues<Dim, R>& values) { return &values.mass[0]; });
  add("moved_mass", [](NodeValues<Dim, R>& values) { return &values.moved_mass[0]; });
  for (int d = 0; d < Dim; ++d) {
    const std::string axis(1, "xyz"[d]);
    add("momentum_" + axis, [d](NodeValues<Dim, R>& values) { return &values.momentum[d][0]; });
    add("force_" + axis, [d](NodeValues<Dim, R>& values) { return &values.force[d][0]; });
    add("velocity_" + axis, [d](NodeValues<Dim, R>& values) { return &values.velocity[d][0]; });
  }
  // Which surfaces pressed and held in the last step, for the first velocities of the next.
  std::vector<std::array<bool, 2>> touches;
  for (const TileType* tile : tiles) {
    for (const SurfaceContact<Dim>& contact : tile->contacts) touches.push_back({contact.presses, contact.sticks});
  }
  const std::size_t touch_count = touches.size();
  state.add("surface_contacts", touches);
  if (touches.size() != touch_count) state.fail("surface_contacts", fmt::format("has {} rows, not {}", touches.size(), touch_count));
  std::size_t next = 0;
  for (TileType* tile : tiles) {
    for (SurfaceContact<Dim>& contact : tile->contacts) {
      contact.presses = touches[next][0];
      contact.sticks = touches[next++][1];
    }
  }
}

template <int Dim, class R>
std::vector<Field> Grid<Dim, R>::fields() const {
  const auto count = static_cast<std::size_t>(node_count());
  Field mass{"mass", "kg", 1, std::vector<Real>(count, 0)};
  Field velocity{"velocity", "m/s", Dim, std::vector<Real>(count * Dim, 0)};
  for (const Band& band : bands_) {
    for (const TileType* tile : band.tiles) {
      for_each_node(*tile, [&](int lane, std::size_t node) {
        mass.values[node] = static_cast<Real>(tile->values.moved_mass[lane]);
        for (std::size_t d = 0; d < Dim; ++d) velocity.values[node * Dim + d] = static_cast<Real>(tile->values.velocity[d][lane]);
      });
    }
  }
  return {mass, velocity};
}

template <int Dim, class R>
Index Grid<Dim, R>::tile_count() const {
  Index count = 0;
  for (const Band& band : bands_) count += static_cast<Index>(band.tiles.size());
  return count;
}

template <int Dim, class R>
Index Grid<Dim, R>::memory() const {
  auto bytes = static_cast<std::size_t>(tiles_.memory()) + bands_.size() * sizeof(Band);
  // Beside the lists, an entry in the map has a link and a hash.
  for (const Band& band : bands_) {
    bytes += (band.tiles.capacity() + band.unused.capacity()) * sizeof(void*) + band.by_key.size() * 5 * sizeof(void*);
  }
  return static_cast<Index>(bytes);
}

template class Grid<2, double>;
template class Grid<3, double>;
template class Grid<2, float>;
template class Grid<3, float>;

}  // namespace matpoint
