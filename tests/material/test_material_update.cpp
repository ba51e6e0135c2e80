// A law's kernel over the lanes of a block must do what the law says point by point, keep its history, sum the dissipation, and name
// the first point that turned inside out; and the law's face at run time passes its numbers.
#include "kernel/law_kernel.hpp"
#include "material/damaged_neo_hookean.hpp"
#include "material/law_samples.hpp"

namespace matpoint::test {
namespace {

/// A law with history: the pressure follows from the greatest J so far, and the second number counts evaluations.
struct Ratchet {
  static constexpr auto name = "ratchet";
  static constexpr auto summary = "For this test only.";
  Real density = 1;
  Real stiffness = 1;
  static void declare(ParameterTable<Ratchet>& table) {
    table.optional("density", "kg/m^3", &Ratchet::density, positive(), "Density.");
    table.optional("stiffness", "Pa", &Ratchet::stiffness, positive(), "Stiffness.");
  }
  template <class T>
  struct History {
    T largest_J;
    T count;
  };
  template <class M, class T = typename M::Scalar>
  M kirchhoff_stress(const Kinematics<M>& k, const History<T>& old_history, History<T>& updated) const {
    const T J = determinant(k.F);
    updated.largest_J = select(J > old_history.largest_J, J, old_history.largest_J);
    updated.count = T(old_history.count + 1.0);
    return M::diagonal(T(stiffness * (updated.largest_J - 1.0)));
  }
  Real wave_speed(Real) const { return std::sqrt(stiffness / density); }
};

/// Points with random F and L, in the layout of a body: one array per component.
struct Points {
  Points(int dimension, Index number, Index history_size, Real rate) : dim(dimension), count(number) {
    Samples samples;
    const auto n = static_cast<std::size_t>(count);
    F.assign(static_cast<std::size_t>(dim * dim), std::vector<Real>(n));
    L = F;
    tau.assign(dim == 2 ? 4 : 6, std::vector<Real>(n, -77));
    history.assign(static_cast<std::size_t>(history_size), std::vector<Real>(n));
    for (std::size_t p = 0; p < n; ++p) {
      const Eigen::Matrix3d deformation = samples.deformation(0.2);
      const Eigen::Matrix3d gradient = samples.matrix(rate);
      for (int r = 0; r < dim; ++r) {
        for (int c = 0; c < dim; ++c) {
          F[index(r, c)][p] = deformation(r, c);
          L[index(r, c)][p] = gradient(r, c);
        }
      }
      volume0.push_back(0.5 + 0.1 * static_cast<Real>(p));
    }
  }
  std::size_t index(int r, int c) const { return static_cast<std::size_t>(r * dim + c); }

  struct Outcome {
    Real dissipated;
    int first_inverted;
  };

  template <class Law>
  Outcome update(const Law& law, Real dt) {
    return dim == 2 ? update_in<2>(law, dt) : update_in<3>(law, dt);
  }

  /// Point p is in slot p / 8, lane p % 8.
  template <int Dim, class Law>
  Outcome update_in(const Law& law, Real dt) {
    constexpr int lanes = k_lanes<Real>;
    SlotLayout<Dim> layout;
    layout.volume = layout.F + Dim * Dim;
    layout.history = layout.volume + 1;
    layout.u = keeps_shape ? 0 : -1;  // the kernel only asks whether there is one
    layout.field_count = layout.history + static_cast<int>(history.size());
    struct alignas(64) Line {
      Real lane[lanes];
    };
    const int slots = static_cast<int>(count + lanes - 1) / lanes;
    std::vector<Line> storage(static_cast<std::size_t>(slots * layout.field_count), Line{});
    std::vector<Line> gradients(static_cast<std::size_t>(slots * Dim * Dim), Line{});
    std::vector<Line> stresses(static_cast<std::size_t>(slots * k_stress_size<Dim>), Line{});
    Line counts{}, J_min{}, J_max{}, wave_modulus{};
    std::vector<Real*> slot(static_cast<std::size_t>(slots));
    for (int k = 0; k < slots; ++k) slot[static_cast<std::size_t>(k)] = storage[static_cast<std::size_t>(k * layout.field_count)].lane;
    const auto field = [&](int f, std::size_t p) -> Real& {
      return storage[p / lanes * static_cast<std::size_t>(layout.field_count) + static_cast<std::size_t>(f)].lane[p % lanes];
    };
    const auto n = static_cast<std::size_t>(count);
    for (std::size_t p = 0; p < n; ++p) {
      counts.lane[p % lanes] += 1;
      field(layout.volume, p) = volume0[p];
      for (std::size_t h = 0; h < history.size(); ++h) field(layout.history + static_cast<int>(h), p) = history[h][p];
      for (std::size_t k = 0; k < F.size(); ++k) {
        field(layout.F + static_cast<int>(k), p) = F[k][p];
        gradients[p / lanes * F.size() + k].lane[p % lanes] = L[k][p];
      }
    }
    std::vector<int> slots_in_use(k_parts_max, slots);
    LawChunk<Dim, Real> chunk;
    chunk.slots_in_use = slots_in_use.data();
    chunk.slots = slot.data();
    chunk.counts = counts.lane;
    chunk.layout = &layout;
    chunk.dt = dt;
    chunk.L = gradients[0].lane;
    chunk.tau = stresses[0].lane;
    chunk.J_min = J_min.lane;
    chunk.J_max = J_max.lane;
    chunk.wave_modulus = wave_modulus.lane;
    chunk.dissipated = -5;  // what was there before is no part of the sum
    update_law<Law, Dim, Real>(&law, chunk);
    for (std::size_t p = 0; p < n; ++p) {
      for (std::size_t h = 0; h < history.size(); ++h) history[h][p] = field(layout.history + static_cast<int>(h), p);
      for (std::size_t k = 0; k < F.size(); ++k) F[k][p] = field(layout.F + static_cast<int>(k), p);
      for (std::size_t s = 0; s < tau.size(); ++s) tau[s][p] = stresses[p / lanes * tau.size() + s].lane[p % lanes];
    }
    return {chunk.dissipated, chunk.bad_slot < 0 ? -1 : chunk.bad_slot * lanes + chunk.bad_lane};
  }

  /// 3x3 with the given number at zz in 2D.
  Eigen::Matrix3d tensor(const std::vector<std::vector<Real>>& a, std::size_t p, Real zz) const {
    Eigen::Matrix3d result = Eigen::Vector3d(0, 0, zz).asDiagonal();
    for (int r = 0; r < dim; ++r) {
      for (int c = 0; c < dim; ++c) result(r, c) = a[index(r, c)][p];
    }
    return result;
  }
  /// Stress of a point [xx yy zz xy (yz xz)] as a tensor.
  Eigen::Matrix3d stress_of(std::size_t p) const {
    Eigen::Matrix3d result = Eigen::Vector3d(tau[0][p], tau[1][p], tau[2][p]).asDiagonal();
    result(0, 1) = result(1, 0) = tau[3][p];
    if (dim == 3) {
      result(1, 2) = result(2, 1) = tau[4][p];
      result(0, 2) = result(2, 0) = tau[5][p];
    }
    return result;
  }

  int dim;
  Index count;
  bool keeps_shape = true;  ///< As a total Lagrangian body does also of a fluid.
  std::vector<std::vector<Real>> F, L, tau, history;
  std::vector<Real> volume0;
};

template <class Law>
class MaterialUpdateTest : public testing::Test {};
struct LawNames {
  template <class Law>
  static std::string GetName(int) {
    return Law::name;
  }
};
TYPED_TEST_SUITE(MaterialUpdateTest, TestedLaws, LawNames);

TYPED_TEST(MaterialUpdateTest, block_gets_new_F_stress_and_dissipation_of_each_point) {
  using Law = TypeParam;
  for (const int dim : {2, 3}) {
    LawMaterial<Law> material;
    material.law = sample_law<Law>(0);
    const Real dt = 0.01;
    const Points before(dim, 37, k_history_size<Law>, 10);  // odd: the remainder of a vectorised loop counts, too
    Points after = before;
    const Points::Outcome block = after.update(material.law, dt);
    Real dissipated = 0;
    for (std::size_t p = 0; p < 37; ++p) {
      const Eigen::Matrix3d L = before.tensor(before.L, p, 0);
      const Eigen::Matrix3d F = (Eigen::Matrix3d::Identity() + dt * L) * before.tensor(before.F, p, 1);
      EXPECT_LT((after.tensor(after.F, p, 1) - F).norm(), 10 * k_epsilon * F.norm());
      const Eigen::Matrix3d tau = stress(material.law, F, L);
      // The kernel may fuse products: round-off only, which J^-gamma multiplies by gamma.
      EXPECT_LT((after.stress_of(p) - tau).norm(), 100 * k_epsilon * (tau.norm() + 3 * stiffness(material.law))) << dim << "D, point " << p;
      if constexpr (has_dissipation<Law>) {
        dissipated += dt * before.volume0[p] * material.law.dissipation_rate(Kinematics<Full>{from_eigen(F), from_eigen(L), dt});
      }
    }
    EXPECT_EQ(block.first_inverted, -1);
    EXPECT_NEAR(block.dissipated, dissipated, 100 * k_epsilon * dissipated);
  }
}

TEST(MaterialUpdate, fluid_carries_its_volume_alone_and_forgets_its_shape) {
  for (const int dim : {2, 3}) {
    const NewtonianFluid water = sample_law<NewtonianFluid>(0);
    Points points(dim, 37, 0, 10);
    points.keeps_shape = false;
    for (std::size_t p = 0; p < 37; ++p) {
      for (int r = 0; r < dim; ++r) {
        for (int c = 0; c < dim; ++c) points.F[points.index(r, c)][p] = r == c ? 1 + 0.01 * static_cast<Real>(p % 5) : 0;
      }
    }
    const Points before = points;
    const Real dt = 0.01;
    const int steps = 1000;  // in which I + dt L would shear F by e^100
    for (int step = 0; step < steps; ++step) {
      points.update(water, dt);
      if (step == 0) {
        for (std::size_t p = 0; p < 37; ++p) {
          const Eigen::Matrix3d L = points.tensor(points.L, p, 0);
          const Real stretch = std::exp(dt * L.trace() / dim);
          Eigen::Matrix3d F = before.tensor(before.F, p, 1);
          F.topLeftCorner(dim, dim) *= stretch;
          EXPECT_LT((points.tensor(points.F, p, 1) - F).norm(), 20 * k_epsilon * F.norm());
          const Eigen::Matrix3d tau = stress(water, F, L);
          EXPECT_LT((points.stress_of(p) - tau).norm(), 200 * k_epsilon * (tau.norm() + 3 * stiffness(water)));
        }
      }
      for (auto& component : points.L) {
        for (Real& value : component) value = -value;  // there and back again
      }
    }
    for (std::size_t p = 0; p < 37; ++p) {
      const Real J = points.tensor(points.F, p, 1).determinant();
      EXPECT_NEAR(J, before.tensor(before.F, p, 1).determinant(), 2 * steps * k_epsilon * J);
    }
  }
}

TYPED_TEST(MaterialUpdateTest, face_at_run_time_passes_the_numbers_of_the_law) {
  using Law = TypeParam;
  LawMaterial<Law> material;
  material.law = sample_law<Law>(1);
  const Material& face = material;
  Samples samples;
  const Eigen::Matrix3d F = samples.deformation();
  std::array<Real, 9> entries{};
  std::copy_n(from_eigen(F).entries, 9, entries.begin());
  EXPECT_EQ(face.type(), Law::name);
  EXPECT_EQ(face.density(), material.law.density);
  EXPECT_EQ(face.wave_speed(1.1), material.law.wave_speed(1.1));
  if constexpr (has_energy<Law>) {
    EXPECT_EQ(face.energy_density(entries), material.law.energy_density(from_eigen(F)));
  } else {
    EXPECT_EQ(face.energy_density(entries), 0);
  }
  // Reading what was written gives the same parameters.
  Law again;
  parameters_of<Law>().read(face.write(3), {3, ""}, again, {"type"});
  EXPECT_EQ(stress(again, F), stress(material.law, F));
  EXPECT_EQ(again.density, material.law.density);
}

TEST(MaterialUpdate, first_inverted_point_is_named_and_the_others_are_right) {
  for (const int dim : {2, 3}) {
    LawMaterial<NeoHookean> material;
    material.law = sample_law<NeoHookean>(0);
    const Points before(dim, 9, 0, 10);
    Points healthy = before;
    healthy.update(material.law, 0.01);
    for (const Real bad : {-300.0, std::numeric_limits<Real>::quiet_NaN(), std::numeric_limits<Real>::infinity()}) {
      Points points = before;
      for (const std::size_t p : {std::size_t{4}, std::size_t{6}}) {
        for (std::size_t k = 0; k < points.L.size(); ++k) points.L[k][p] = 0;
        points.L[0][p] = bad;  // 1 + L dt = -2: turned inside out
      }
      const Points::Outcome block = points.update(material.law, 0.01);
      EXPECT_EQ(block.first_inverted, 4);
      for (std::size_t p = 0; p < 9; ++p) {
        if (p == 4 || p == 6) continue;
        EXPECT_EQ(points.stress_of(p), healthy.stress_of(p)) << dim << "D, point " << p;
        EXPECT_EQ(points.tensor(points.F, p, 1), healthy.tensor(healthy.F, p, 1));
      }
    }
  }
}

TEST(MaterialUpdate, history_of_a_law_goes_from_step_to_step_with_its_point) {
  for (const int dim : {2, 3}) {
    LawMaterial<Ratchet> material;
    material.law.stiffness = 3;
    EXPECT_EQ(static_cast<const Material&>(material).history_size(3), 2);
    Points points(dim, 5, 2, 0);
    std::vector<Real> largest(5, 0);
    const Real dt = 0.1;
    for (int step = 0; step < 6; ++step) {
      // Each point swells and shrinks at its own rate.
      for (std::size_t p = 0; p < 5; ++p) {
        for (int d = 0; d < dim; ++d) points.L[points.index(d, d)][p] = (step % 3 == 0 ? 1.0 : -0.3) * (1 + static_cast<Real>(p)) * 0.2;
      }
      points.update(material.law, dt);
      for (std::size_t p = 0; p < 5; ++p) {
        largest[p] = std::max(largest[p], points.tensor(points.F, p, 1).determinant());
        EXPECT_NEAR(points.history[0][p], largest[p], 10 * k_epsilon);
        EXPECT_EQ(points.history[1][p], step + 1);
        const Eigen::Matrix3d tau = 3 * (largest[p] - 1) * Eigen::Matrix3d::Identity();
        EXPECT_LT((points.stress_of(p) - tau).norm(), 100 * k_epsilon);
      }
    }
    EXPECT_NE(largest[0], largest[1]);
    EXPECT_LT(points.tensor(points.F, 0, 1).determinant(), largest[0]) << "the last step should be on the way back";
  }
}

TEST(MaterialUpdate, damage_grows_on_loading_and_stays_on_unloading) {
  LawMaterial<DamagedNeoHookean> material;
  material.law.density = 1000;
  material.law.youngs_modulus = 1e4;
  material.law.poissons_ratio = 0.3;
  material.law.damage_energy = 500;
  const NeoHookean virgin{material.law};
  Points points(2, 1, 1, 0);
  Real energy_max = 0;
  for (int step = 0; step < 20; ++step) {
    points.L[1][0] = step < 10 ? 0.5 : -0.3;  // shear, and back
    points.update(material.law, 0.1);
    const Eigen::Matrix3d F = points.tensor(points.F, 0, 1);
    energy_max = std::max(energy_max, virgin.energy_density(from_eigen(F)));
    const Eigen::Matrix3d tau = std::exp(-energy_max / 500) * stress(virgin, F);
    EXPECT_LT((points.stress_of(0) - tau).norm(), 100 * k_epsilon * 1e4);
  }
  EXPECT_GT(energy_max, 100);
  EXPECT_LT(virgin.energy_density(from_eigen(points.tensor(points.F, 0, 1))), 0.9 * energy_max) << "it should be on the way back";
}

/// The ratchet written with a branch.
struct BranchingRatchet : Ratchet {
  static constexpr bool is_scalar_only = true;
  static void declare(ParameterTable<BranchingRatchet>&) {}
  template <class M, class T = typename M::Scalar>
  M kirchhoff_stress(const Kinematics<M>& k, const History<T>& old_history, History<T>& updated) const {
    const T J = determinant(k.F);
    updated = {old_history.largest_J, T(old_history.count + 1)};
    if (J > old_history.largest_J) updated.largest_J = J;
    return M::diagonal(T(stiffness * (updated.largest_J - 1)));
  }
};

TEST(MaterialUpdate, law_that_branches_runs_lane_by_lane_to_the_same_numbers) {
  for (const int dim : {2, 3}) {
    Points packed(dim, 21, 2, 5);
    Points lane_by_lane = packed;
    for (int step = 0; step < 3; ++step) {
      packed.update(Ratchet{}, 0.01);
      lane_by_lane.update(BranchingRatchet{}, 0.01);
    }
    // F is the same text; what the law makes of it may differ by fused products in J.
    EXPECT_EQ(packed.F, lane_by_lane.F);
    for (std::size_t p = 0; p < 21; ++p) {
      EXPECT_LT((packed.stress_of(p) - lane_by_lane.stress_of(p)).norm(), 100 * k_epsilon);
      EXPECT_EQ(packed.history[1][p], lane_by_lane.history[1][p]);
    }
  }
  EXPECT_TRUE(static_cast<const Material&>(LawMaterial<BranchingRatchet>{}).is_scalar_only());
  EXPECT_FALSE(static_cast<const Material&>(LawMaterial<Ratchet>{}).is_scalar_only());
}

TEST(MaterialUpdate, laws_without_history_energy_or_viscosity_have_none) {
  EXPECT_EQ(k_history_size<NeoHookean>, 0);
  EXPECT_EQ(k_history_size<NewtonianFluid>, 0);
  const LawMaterial<Ratchet> ratchet;
  EXPECT_EQ(static_cast<const Material&>(ratchet).energy_density({2, 0, 0, 0, 1, 0, 0, 0, 1}), 0);
  EXPECT_EQ(static_cast<const Material&>(ratchet).kinematic_viscosity(1), 0);
  LawMaterial<NewtonianFluid> fluid;
  fluid.law.density = 1000;
  fluid.law.viscosity = 5;
  // mu / rho with rho = rho0 / J
  EXPECT_NEAR(static_cast<const Material&>(fluid).kinematic_viscosity(0.8), 5 / (1000 / 0.8), 10 * k_epsilon);
}

}  // namespace
}  // namespace matpoint::test
