// A material point on a given path F(t): what the tests of laws that flow drive.
#pragma once

#include <fstream>
#include <sstream>

#include "case/case_file.hpp"
#include "material/law_samples.hpp"

namespace matpoint::test {

/// A law that flows, with its history, at one point.
template <class Law, bool is_plane = false>
class PointOnPath {
 public:
  using M = Mat3<Real, is_plane>;
  explicit PointOnPath(const Law& law) : law_(law) {}

  /// Under a pressure [Pa], without having flowed.
  void press(Real pressure) {
    // The pressure rises with the compression, whatever the law.
    Real low = -1, high = 0;
    for (int i = 0; i < 100; ++i) {
      const Real middle = 0.5 * (low + high);
      for (int d = 0; d < 3; ++d) history.h[d] = std::expm1(2 * middle);
      tau = law_.stress_of(M::identity(), history);
      (-trace(tau) / 3 > pressure ? low : high) = middle;
    }
  }
  /// To F, from where it is.
  void step(const Eigen::Matrix3d& F, Real dt) {
    Kinematics<M> k{M::identity(), M::zero(), dt, M::zero()};
    const Eigen::Matrix3d g = (F - F_) * F_.inverse();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        if (!M::is_stored(r, c)) continue;
        k.F(r, c) = F(r, c);
        k.g(r, c) = g(r, c);
        if (dt > 0) k.L(r, c) = g(r, c) / dt;
      }
    }
    auto updated = history;
    Real lost = 0;
    tau = law_.update(k, history, updated, lost);
    history = updated;
    dissipated += lost;
    F_ = F;
  }

  M tau = M::zero();
  Real dissipated = 0;
  typename Law::template History<Real, is_plane> history{};

 private:
  const Law law_;
  Eigen::Matrix3d F_ = Eigen::Matrix3d::Identity();
};

/// The law with the parameters of a table in TOML.
template <class Law>
Law law_of(const std::string& text, int dim = 3) {
  Law law;
  read_law(parse_toml(text, "law.toml"), {dim, ""}, law);
  return law;
}

/// Which F at the time t in [0, 1], as data/points.csv names the paths; `cyclic_shear_0.1` counts steps.
inline Eigen::Matrix3d path_of(const std::string& name, Real t) {
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  const auto ends_with_number = [&](const std::string& start) { return std::stod(name.substr(start.size())); };
  if (name.starts_with("shear_2")) F(0, 1) = 2 * t;
  if (name.starts_with("uniaxial_strain_")) F(0, 0) = std::exp(t * ends_with_number("uniaxial_strain_"));
  if (name.starts_with("isotropic_"))
    F *= std::exp(t * ends_with_number(name.starts_with("isotropic_s") ? "isotropic_stretch_" : "isotropic_") / 3);
  if (name.starts_with("isochoric_stretch_")) F = Eigen::Vector3d(std::exp(t), std::exp(-t / 2), std::exp(-t / 2)).asDiagonal();
  if (name.starts_with("shear_0.4")) F(0, 1) = 0.4 * t;
  if (name == "cyclic_shear_0.1") F(0, 1) = t <= 100 ? 0.001 * t : t <= 300 ? 0.1 - 0.001 * (t - 100) : -0.1 + 0.001 * (t - 300);
  if (name.ends_with("_spun3rad_123")) F = Eigen::AngleAxisd(3 * t, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix() * F;
  return F;
}

/// A row of data/points.csv; nan: not given.
struct PointRow {
  std::string set, test, kind;
  Real t = 0;
  std::array<Real, 6> tau{};  ///< xx yy zz xy yz xz [Pa]
  Real plastic_strain = 0, dissipated = 0;
};
inline std::vector<PointRow> point_rows() {
  std::ifstream file(std::string(MATPOINT_TEST_DATA) + "/points.csv");
  std::vector<PointRow> rows;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::stringstream cells(line);
    PointRow row;
    std::string cell;
    std::getline(cells, row.set, ',');
    std::getline(cells, row.test, ',');
    std::getline(cells, row.kind, ',');
    const auto number = [&] {
      std::getline(cells, cell, ',');
      return cell.empty() ? std::numeric_limits<Real>::quiet_NaN() : std::stod(cell);
    };
    row.t = number();
    for (Real& value : row.tau) value = number();
    row.plastic_strain = number();
    row.dissipated = number();
    rows.push_back(row);
  }
  return rows;
}

}  // namespace matpoint::test
