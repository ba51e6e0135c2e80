#include "implicit/assembly.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "implicit/background_reset.hpp"
#include "implicit/point_kernels.hpp"

namespace matpoint {
namespace {

/// Cells that are worked before their matrices are added to the sparse one.
constexpr std::size_t k_batch = 64;
/// Particles whose stresses are evaluated at once.
constexpr Index k_chunk = 64;

}  // namespace

/// The loops over the particles of a cell, with the number of functions known to the compiler.
template <int Dim>
struct Assembly<Dim>::Kernels {
  static constexpr int k_matrix = Dim * Dim;
  static constexpr int k_tangent = k_matrix * k_matrix;

  template <int N>
  static void work_cell(const Assembly& self, std::size_t cell, const std::vector<Real>& u, const StepLoad<Dim>& load, Real* residual,
                        Real* K) {
    const StepSpace<Dim>& space = self.space_;
    const std::size_t source = space.source_of(cell);
    const PointBody<Dim>& body = *space.sources()[source].points;
    const Law& law = self.laws_[source];
    Real u_cell[N * Dim];
    const int* const nodes = space.cell_nodes(cell);
    for (int k = 0; k < N; ++k) std::copy_n(u.data() + nodes[k] * Dim, Dim, u_cell + k * Dim);
    std::fill_n(residual, N * Dim, 0);
    Real mass_matrix[N * N] = {};
    if (K != nullptr) std::fill_n(K, N * Dim * N * Dim, 0);
    Real A[k_chunk * k_matrix];
    Real F[k_chunk * k_matrix];
    Real S[k_chunk * k_matrix];
    Real D[k_chunk * k_tangent];
    const auto history_size = static_cast<std::size_t>(body.material().history_size(Dim));
    std::vector<Real> history(static_cast<std::size_t>(k_chunk) * history_size);
    for (Index first = space.cell_begin(cell); first < space.cell_end(cell); first += k_chunk) {
      const Index count = std::min(k_chunk, space.cell_end(cell) - first);
      for (Index k = 0; k < count; ++k) {
        const auto p = static_cast<std::size_t>(space.particles()[static_cast<std::size_t>(first + k)]);
        deformation<Dim, N>(u_cell, space.trial_gradients(first + k), A + k * k_matrix);
        std::copy_n(body.F.data() + p * k_matrix, k_matrix, F + k * k_matrix);
        std::copy_n(body.history.data() + p * history_size, history_size, history.data() + static_cast<std::size_t>(k) * history_size);
      }
      TangentPoints points;
      points.count = count;
      points.dt = load.dt;
      points.A = A;
      points.F = F;
      points.history = history.data();
      points.S = S;
      points.tangent = K != nullptr ? D : nullptr;
      law.evaluate(law.data, points);
      for (Index k = 0; k < count; ++k) {
        const auto p = static_cast<std::size_t>(space.particles()[static_cast<std::size_t>(first + k)]);
        const Real* const N_p = space.N(first + k);
        const Real* const g = space.gradients(first + k);
        const Real volume = body.volume0[p];
        const Real mass = body.mass[p];
        Real force[Dim];  // m (acceleration - b)
        for (int i = 0; i < Dim; ++i) {
          const auto s = static_cast<std::size_t>(i);
          Real du = 0;
          for (int node = 0; node < N; ++node) du += N_p[node] * u_cell[node * Dim + i];
          const Real acceleration = load.inertia.u * du - load.inertia.v * body.velocity[p][s] - load.inertia.a * body.acceleration[p][s];
          force[i] = mass * (acceleration - load.b(source, law.weight_ratio, p, s));
        }
        for (int node = 0; node < N; ++node) {
          for (int i = 0; i < Dim; ++i) {
            Real sum = N_p[node] * force[i];
            for (int j = 0; j < Dim; ++j) sum += volume * S[k * k_matrix + i * Dim + j] * g[node * Dim + j];
            residual[node * Dim + i] += sum;
          }
        }
        if (K == nullptr) continue;
        add_stiffness<Dim, N>(volume, D + k * k_tangent, g, space.trial_gradients(first + k), K);
        if (load.inertia.u == 0) continue;
        for (int I = 0; I < N; ++I) {
          const Real m = mass * load.inertia.u * N_p[I];
          for (int node = 0; node < N; ++node) mass_matrix[I * N + node] += m * N_p[node];
        }
      }
    }
    if (K != nullptr) {
      for (int I = 0; I < N; ++I) {
        for (int node = 0; node < N; ++node) {
          for (int i = 0; i < Dim; ++i) K[(I * Dim + i) * N * Dim + node * Dim + i] += mass_matrix[I * N + node];
        }
      }
    }
    const int soft = self.soft_cells_[cell];
    if (soft < 0) return;
    const Real* const stiffness = self.soft_stiffness_.data() + static_cast<std::size_t>(soft) * N * Dim * N * Dim;
    for (int row = 0; row < N * Dim; ++row) {
      for (int column = 0; column < N * Dim; ++column) {
        const Real entry = stiffness[row * N * Dim + column];
        residual[row] += entry * u_cell[column];
        if (K != nullptr) K[row * N * Dim + column] += entry;
      }
    }
  }

  using WorkCell = void (*)(const Assembly&, std::size_t, const std::vector<Real>&, const StepLoad<Dim>&, Real*, Real*);
  static WorkCell choose(int functions) {
    return functions == whole_power(2, Dim) ? &work_cell<whole_power(2, Dim)> : &work_cell<whole_power(3, Dim)>;
  }
};

namespace {

/// The shear modulus of a law at rest, or, of a law without one, the modulus of its pressure waves [Pa].
template <int Dim>
Real modulus_at_rest(TangentFunction<Dim> evaluate, const Material& material) {
  constexpr int n = Dim * Dim;
  Real A[n] = {};
  for (int d = 0; d < Dim; ++d) A[d * Dim + d] = 1;
  Real S[n];
  Real D[n * n];
  const std::vector<Real> history(static_cast<std::size_t>(std::max(1, material.history_size(Dim))), 0);
  TangentPoints point;
  point.count = 1;
  point.A = A;
  point.F = A;
  point.history = history.data();
  point.S = S;
  point.tangent = D;
  evaluate(material.law_data(), point);
  const Real shear = D[1 * n + 1];  // dS_xy / dA_xy
  return shear > 0 ? shear : D[0];
}

}  // namespace

template <int Dim>
Assembly<Dim>::Assembly(const StepSpace<Dim>& space, BodyContact<Dim>& contact, const SideContact<Dim>& sides, PointLoads<Dim>& loads,
                        int patch_width, bool has_linear_patches, Real surface_penalty)
    : space_(space),
      contact_(contact),
      sides_(sides),
      loads_(loads),
      patches_(space, patch_width, has_linear_patches),
      surface_penalty_(surface_penalty) {
  for (const PointSource<Dim>& source : space.sources()) {
    const Material& material = source.points->material();
    const TangentFunction<Dim> evaluate = tangent_function<Dim>(material);
    if (evaluate == nullptr) {
      throw InputError("body \"{}\": the implicit solver needs a law's exact tangent, which the law \"{}\" does not have",
                       source.points->name(), material.type());
    }
    laws_.push_back(
        {evaluate, material.law_data(), modulus_at_rest<Dim>(evaluate, material), source.fem != nullptr ? source.fem->weight_ratio() : 1});
  }
}

template <int Dim>
void Assembly<Dim>::start() {
  const bool is_new_space = space_pattern_ != space_.pattern();
  if (is_new_space) {
    patches_.gather();
    if (surface_penalty_ > 0) faces_ = surface_faces(space_);
  }
  if (is_new_space || contact_pattern_ != contact_.pattern()) make_pattern();
  patches_.evaluate();
  loads_.start();
  measure_emptiness(space_, faces_);
  // On a background that moves the cells change their shape from step to step.
  if (is_new_space || space_.moves_basis()) make_soft_stiffness();
  space_pattern_ = space_.pattern();
}

template <int Dim>
void Assembly<Dim>::make_pattern() {
  ++pattern_;
  contact_pattern_ = contact_.pattern();
  const std::size_t node_count = space_.nodes().size();
  const auto functions = static_cast<std::size_t>(space_.functions());
  std::vector<std::vector<int>> neighbours(node_count);
  for (std::size_t c = 0; c < space_.cells().size(); ++c) {
    const int* const nodes = space_.cell_nodes(c);
    for (std::size_t k = 0; k < functions; ++k)
      neighbours[static_cast<std::size_t>(nodes[k])].insert(neighbours[static_cast<std::size_t>(nodes[k])].end(), nodes, nodes + functions);
  }
  const auto couple = [&](const std::vector<int>& nodes) {
    for (const int node : nodes) {
      std::vector<int>& around = neighbours[static_cast<std::size_t>(node)];
      around.insert(around.end(), nodes.begin(), nodes.end());
    }
  };
  for (const VolumePatch<Dim>& patch : patches_.all()) couple(patch.nodes);
  for (const SurfaceFace<Dim>& face : faces_) couple(face.nodes);
  for (const ContactPatch<Dim>& patch : contact_.patches()) couple(patch.nodes);
  const auto unknowns_of = [&](int node) {
    int count = 0;
    for (int d = 0; d < Dim; ++d) count += space_.unknown(node, d) >= 0 ? 1 : 0;
    return count;
  };
  first_unknown_.assign(node_count + 1, 0);
  for (std::size_t n = 0; n < node_count; ++n) first_unknown_[n + 1] = first_unknown_[n] + unknowns_of(static_cast<int>(n));
  // Columns of the sparse matrix, one for each unknown of each node.
  const int size = space_.unknown_count();
  std::vector<int> outer(static_cast<std::size_t>(size) + 1, 0);
  std::vector<int> inner;
  for (std::size_t n = 0; n < node_count; ++n) {
    std::vector<int>& around = neighbours[n];
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    for (int column = first_unknown_[n]; column < first_unknown_[n + 1]; ++column) {
      for (const int other : around) {
        for (int row = first_unknown_[static_cast<std::size_t>(other)]; row < first_unknown_[static_cast<std::size_t>(other) + 1]; ++row)
          inner.push_back(row);
      }
      constexpr auto k_entries_max = static_cast<std::size_t>(std::numeric_limits<int>::max());
      if (inner.size() > k_entries_max)
        throw SolverError("the matrix of {} unknowns has more than {} entries, which is all that it can have: take larger cells", size,
                          k_entries_max);
      outer[static_cast<std::size_t>(column) + 1] = static_cast<int>(inner.size());
    }
  }
  matrix_.resize(size, size);
  matrix_.makeCompressed();
  matrix_.resizeNonZeros(static_cast<Eigen::Index>(inner.size()));
  std::copy(outer.begin(), outer.end(), matrix_.outerIndexPtr());
  std::copy(inner.begin(), inner.end(), matrix_.innerIndexPtr());
  // Of some nodes, by pair (I, K).
  const auto offsets_of = [&](const int* nodes, std::size_t count, int* offsets) {
    for (std::size_t K = 0; K < count; ++K) {
      const std::vector<int>& around = neighbours[static_cast<std::size_t>(nodes[K])];
      // Rows before a neighbour in the columns of K.
      std::vector<int> before(around.size() + 1, 0);
      for (std::size_t a = 0; a < around.size(); ++a) before[a + 1] = before[a] + unknowns_of(around[a]);
      for (std::size_t I = 0; I < count; ++I) {
        const auto a = std::lower_bound(around.begin(), around.end(), nodes[I]) - around.begin();
        offsets[I * count + K] = before[static_cast<std::size_t>(a)];
      }
    }
  };
  row_offset_.resize(space_.cells().size() * functions * functions);
  for (std::size_t c = 0; c < space_.cells().size(); ++c)
    offsets_of(space_.cell_nodes(c), functions, row_offset_.data() + c * functions * functions);
  const auto set_offsets = [&](auto& of_nodes) {
    of_nodes.row_offset.resize(of_nodes.nodes.size() * of_nodes.nodes.size());
    offsets_of(of_nodes.nodes.data(), of_nodes.nodes.size(), of_nodes.row_offset.data());
  };
  for (VolumePatch<Dim>& patch : patches_.all()) set_offsets(patch);
  for (SurfaceFace<Dim>& face : faces_) set_offsets(face);
  for (ContactPatch<Dim>& patch : contact_.patches()) set_offsets(patch);
}

/// On cells with C > 0: r += mu C int (grad u + grad u^T) : grad N (eq. 26), on the step's displacement.
template <int Dim>
void Assembly<Dim>::make_soft_stiffness() {
  soft_cells_.assign(space_.cells().size(), -1);
  int count = 0;
  for (std::size_t c = 0; c < soft_cells_.size(); ++c) {
    if (space_.soft_factor(c) > 0) soft_cells_[c] = count++;
  }
  soft_stiffness_.assign(static_cast<std::size_t>(count) * width() * width(), 0);
  parallel_for(static_cast<Index>(soft_cells_.size()), static_cast<Index>(soft_cells_.size()) * 100, [&](Index cell) {
    const auto c = static_cast<std::size_t>(cell);
    if (soft_cells_[c] < 0) return;
    Real* const K = soft_stiffness_.data() + static_cast<std::size_t>(soft_cells_[c]) * width() * width();
    const Real factor = laws_[space_.source_of(c)].soft_modulus * space_.soft_factor(c);
    add_symmetric_gradient_stiffness<Dim>(space_.basis(), space_.cells()[c], factor, K);
  });
}

template <int Dim>
void Assembly<Dim>::scatter(const int* nodes, std::size_t count, const int* offsets, const Real* K, Lift& lift) {
  Real* const values = matrix_.valuePtr();
  const int* const outer = matrix_.outerIndexPtr();
  const std::size_t size = count * Dim;
  for (std::size_t node = 0; node < count; ++node) {
    for (int k = 0; k < Dim; ++k) {
      const int column = space_.unknown(nodes[node], k);
      if (column < 0) {
        const Real u = lift.displacement == nullptr ? 0 : (*lift.displacement)[static_cast<std::size_t>(nodes[node] * Dim + k)];
        if (u == 0) continue;
        for (std::size_t row = 0; row < size; ++row) {
          const int unknown = space_.unknown(nodes[row / Dim], static_cast<int>(row % Dim));
          if (unknown >= 0) lift.force[unknown] += K[row * size + node * Dim + static_cast<std::size_t>(k)] * u;
        }
        continue;
      }
      for (std::size_t I = 0; I < count; ++I) {
        int place = outer[column] + offsets[I * count + node];
        for (int i = 0; i < Dim; ++i) {
          if (space_.unknown(nodes[I], i) < 0) continue;
          values[place++] += K[(I * Dim + static_cast<std::size_t>(i)) * size + node * Dim + static_cast<std::size_t>(k)];
        }
      }
    }
  }
}

template <int Dim>
void Assembly<Dim>::add_friction(const int* nodes, std::size_t count, const std::vector<Real>& u, const StepLoad<Dim>& load, Real* residual,
                                 Real* K) const {
  const std::size_t size = count * Dim;
  for (std::size_t I = 0; I < count; ++I) {
    const auto node = static_cast<std::size_t>(nodes[I]);
    const FaceFriction<Dim>& friction = load.friction[node];
    if (friction.axis < 0) continue;
    const std::size_t across = I * Dim + static_cast<std::size_t>(friction.axis);
    const Vec<Dim> share = friction.at(u.data() + node * Dim);
    for (std::size_t d = 0; d < Dim; ++d) {
      if (d == static_cast<std::size_t>(friction.axis)) continue;
      const std::size_t along = I * Dim + d;
      residual[along] += share[d] * residual[across];
      if (K == nullptr) continue;
      for (std::size_t column = 0; column < size; ++column) K[along * size + column] += share[d] * K[across * size + column];
      for (std::size_t e = 0; e < Dim; ++e) K[along * size + I * Dim + e] += friction.slope[d * Dim + e] * residual[across];
    }
  }
}

template <int Dim>
void Assembly<Dim>::assemble(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift) {
  const bool with_matrix = lift != nullptr;
  const auto work = Kernels::choose(space_.functions());
  const std::size_t cell_count = space_.cells().size();
  residual.assign(space_.nodes().size() * Dim, 0);
  contact_.move(u);
  if (contact_pattern_ != contact_.pattern()) make_pattern();
  if (with_matrix) {
    std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0);
    lift->force = Vector::Zero(space_.unknown_count());
  }
  cell_matrices_.resize(with_matrix ? k_batch * width() * width() : 0);
  cell_residuals_.resize(k_batch * width());
  for (std::size_t first = 0; first < cell_count; first += k_batch) {
    const std::size_t count = std::min(k_batch, cell_count - first);
    const Index particles = space_.cell_end(first + count - 1) - space_.cell_begin(first);
    parallel_for(static_cast<Index>(count), particles * 20, [&](Index c) {
      const auto s = static_cast<std::size_t>(c);
      Real* const cell_residual = cell_residuals_.data() + s * width();
      Real* const cell_matrix = with_matrix ? cell_matrices_.data() + s * width() * width() : nullptr;
      if (patches_.holds(first + s)) return;
      work(*this, first + s, u, load, cell_residual, cell_matrix);
      if (!load.friction.empty())
        add_friction(space_.cell_nodes(first + s), static_cast<std::size_t>(space_.functions()), u, load, cell_residual, cell_matrix);
    });
    for (std::size_t c = 0; c < count; ++c) {
      if (patches_.holds(first + c)) continue;
      const int* const nodes = space_.cell_nodes(first + c);
      for (std::size_t k = 0; k < width(); ++k)
        residual[static_cast<std::size_t>(nodes[k / Dim]) * Dim + k % Dim] += cell_residuals_[c * width() + k];
      if (!with_matrix) continue;
      const auto functions = static_cast<std::size_t>(space_.functions());
      scatter(nodes, functions, row_offset_.data() + (first + c) * functions * functions, cell_matrices_.data() + c * width() * width(),
              *lift);
    }
  }
  if (!patches_.is_empty()) assemble_patches(u, load, residual, lift);
  assemble_faces(u, load, residual, lift);
  assemble_sides(u, load, residual, lift);
  if (!loads_.is_empty()) assemble_loads(u, load, residual, lift);
  assemble_contact(u, load, residual, lift);
  for (std::size_t k = 0; k < load.nodal_force.size(); ++k) residual[k] -= load.nodal_force[k];
}

template <int Dim>
void Assembly<Dim>::deform(const std::vector<Real>& u, std::vector<Real>& A, std::vector<Vec<Dim>>& du) const {
  const auto n = space_.particles().size();
  A.resize(n * Dim * Dim);
  du.assign(n, {});
  const int functions = space_.functions();
  parallel_for(static_cast<Index>(space_.cells().size()), static_cast<Index>(n), [&](Index c) {
    const auto cell = static_cast<std::size_t>(c);
    Real u_cell[27 * Dim];
    const int* const nodes = space_.cell_nodes(cell);
    for (int k = 0; k < functions; ++k) std::copy_n(u.data() + nodes[k] * Dim, Dim, u_cell + k * Dim);
    for (Index k = space_.cell_begin(cell); k < space_.cell_end(cell); ++k) {
      Real* const out = A.data() + k * Dim * Dim;
      if (functions == whole_power(2, Dim))
        deformation<Dim, whole_power(2, Dim)>(u_cell, space_.trial_gradients(k), out);
      else
        deformation<Dim, whole_power(3, Dim)>(u_cell, space_.trial_gradients(k), out);
      const Real* const N = space_.N(k);
      for (int node = 0; node < functions; ++node) {
        for (int d = 0; d < Dim; ++d) du[static_cast<std::size_t>(k)][static_cast<std::size_t>(d)] += N[node] * u_cell[node * Dim + d];
      }
    }
  });
  project_volumes(A);
}

/// Of particles in patches the law sees A' = (Pi j / j)^(1/dim) A.
template <int Dim>
void Assembly<Dim>::project_volumes(std::vector<Real>& A) const {
  for (const VolumePatch<Dim>& patch : patches_.all()) {
    const PointBody<Dim>& body = *space_.sources()[patch.source].points;
    const auto modes = static_cast<std::size_t>(patch.modes);
    std::vector<Real> j, c(modes, 0);
    std::size_t k = 0;
    for (const std::size_t cell : patch.cells) {
      for (Index place = space_.cell_begin(cell); place < space_.cell_end(cell); ++place, ++k) {
        const auto p = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(place)]);
        j.push_back(determinant_of<Dim>(A.data() + place * Dim * Dim));
        for (std::size_t a = 0; a < modes; ++a) c[a] += body.volume0[p] * patch.psi[k * modes + a] * j.back();
      }
    }
    k = 0;
    for (const std::size_t cell : patch.cells) {
      for (Index place = space_.cell_begin(cell); place < space_.cell_end(cell); ++place, ++k) {
        Real mean = 0;
        for (std::size_t a = 0; a < modes; ++a) mean += patch.psi[k * modes + a] * c[a];
        // What is turned inside out stays so, to be seen.
        const Real s = j[k] > 0 ? std::pow(mean / j[k], 1.0 / Dim) : 1;
        for (int e = 0; e < Dim * Dim; ++e) A[static_cast<std::size_t>(place * Dim * Dim + e)] *= s;
      }
    }
  }
}

template <int Dim>
Inversion Assembly<Dim>::find_inversion(const std::vector<Real>& u) const {
  std::vector<Real> A;
  std::vector<Vec<Dim>> du;
  deform(u, A, du);
  Inversion worst;
  space_.for_each_point([&](std::size_t source, std::size_t row, std::size_t k) {
    const Real* const a = A.data() + k * Dim * Dim;
    const Real J = determinant_of<Dim>(a);
    if (J > 0 && std::isfinite(J)) return;
    if (worst.row < 0 || !(J > worst.J)) worst = {source, static_cast<Index>(row), J};
  });
  return worst;
}

template <int Dim>
std::string Assembly<Dim>::find_fault(const std::vector<Real>& u) {
  const Inversion inversion = find_inversion(u);
  if (inversion.is_found()) return describe(inversion);
  contact_.move(u);
  if (contact_pattern_ != contact_.pattern()) make_pattern();
  const std::string overlap = sides_.find_overlap(u);
  return overlap.empty() ? contact_.find_overlap() : overlap;
}

template <int Dim>
std::string Assembly<Dim>::describe(const Inversion& inversion) const {
  const auto row = static_cast<std::size_t>(inversion.row);
  const PointBody<Dim>& body = *space_.sources()[inversion.source].points;
  return fmt::format("det F of {} {} of body \"{}\" at ({:.6g}) would become {:.4g} times what it is",
                     space_.sources()[inversion.source].point_name(), body.id[row], body.name(), fmt::join(body.position[row], ", "),
                     inversion.J);
}

template class Assembly<2>;
template class Assembly<3>;

}  // namespace matpoint
