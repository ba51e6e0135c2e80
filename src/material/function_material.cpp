#include "material/function_material.hpp"

#include <algorithm>
#include <cmath>

namespace matpoint {
namespace {

void require(bool holds, const char* name, Real value, const char* allowed) {
  if (!holds) throw InputError("function law: {} = {} is not allowed, it must be {}", name, value, allowed);
}

}  // namespace

FunctionMaterial::FunctionMaterial(std::string name, Function function, Real density, Real wave_speed, Real kinematic_viscosity,
                                   int history_size, std::vector<std::string> history_names)
    : name_(std::move(name)),
      function_(std::move(function)),
      density_(density),
      wave_speed_(wave_speed),
      kinematic_viscosity_(kinematic_viscosity),
      history_size_(history_size),
      history_names_(std::move(history_names)) {
  require(density > 0 && std::isfinite(density), "density", density, "> 0 [kg/m^3]");
  require(wave_speed > 0 && std::isfinite(wave_speed), "wave_speed", wave_speed, "> 0 [m/s]");
  require(kinematic_viscosity >= 0 && std::isfinite(kinematic_viscosity), "kinematic_viscosity", kinematic_viscosity, ">= 0 [m^2/s]");
  require(history_size >= 0 && history_size <= 1000, "history_size", history_size, "an integer from 0 to 1000");
  for (const std::string& one : history_names_) {
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
    const bool is_name = !one.empty() && is_letter(one[0]) &&
                         std::all_of(one.begin(), one.end(), [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
    if (!is_name)
      throw InputError("function law: history has the name \"{}\"; names are letters, digits and _, as \"damage\"", printable(one));
    if (std::count(history_names_.begin(), history_names_.end(), one) > 1)
      throw InputError("function law: history has the name \"{}\" twice; give each number its own", one);
  }
  if (history_names_.size() > static_cast<std::size_t>(history_size))
    throw InputError("function law: history has {} names for {} numbers", history_names_.size(), history_size);
}

Material::Matrix FunctionMaterial::kirchhoff_stress(const Matrix& F, std::span<const Real> /*history*/) const {
  const Matrix L{};
  Matrix tau{};
  std::vector<Real> history(static_cast<std::size_t>(history_size_), 0);
  evaluate({1, F.data(), L.data(), 0, history.data(), tau.data()});
  return tau;
}

std::vector<InternalVariable> FunctionMaterial::internal_variables() const {
  std::vector<InternalVariable> all;
  for (const std::string& one : history_names_) all.push_back({one.c_str(), "1"});
  return all;
}

Input FunctionMaterial::write(int) const {
  Input table = Input::table();
  table.set("type", Input::string("function"));
  table.set("function", Input::string(name_));
  table.set("density", Input::real(density_));
  table.set("wave_speed", Input::real(wave_speed_));
  table.set("kinematic_viscosity", Input::real(kinematic_viscosity_));
  return table;
}

}  // namespace matpoint
