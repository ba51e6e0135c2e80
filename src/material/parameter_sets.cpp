#include "material/parameter_sets.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "material/material.hpp"

namespace matpoint {
namespace {

using Numbers = std::vector<std::pair<std::string, Real>>;

ParameterSet make(const std::string& name, const std::string& summary, const std::string& type, const Numbers& numbers) {
  Input table = Input::table();
  table.set("type", Input::string(type));
  for (const auto& [key, value] : numbers) table.set(key, Input::real(value));
  return {name, summary, table};
}

}  // namespace

const std::vector<ParameterSet>& parameter_sets() {
  static const std::vector<ParameterSet> sets = {
      make("copper_ofhc", "OFHC copper under impact (Johnson & Cook 1983, 1985).", "johnson_cook",
           {{"density", 8960},
            {"youngs_modulus", 124e9},
            {"poissons_ratio", 0.34},
            {"A", 90e6},
            {"B", 292e6},
            {"n", 0.31},
            {"C", 0.025},
            {"m", 1.09},
            {"melting_temperature", 1356},
            {"heat_capacity", 383},
            {"D1", 0.54},
            {"D2", 4.89},
            {"D3", -3.03},
            {"D4", 0.014},
            {"D5", 1.12}}),
      make("iron_armco", "Armco iron under impact, without failure (Johnson & Cook 1983).", "johnson_cook",
           {{"density", 7890},
            {"youngs_modulus", 207e9},
            {"poissons_ratio", 0.29},
            {"A", 175e6},
            {"B", 380e6},
            {"n", 0.32},
            {"C", 0.06},
            {"m", 0.55},
            {"melting_temperature", 1811},
            {"heat_capacity", 452}}),
      make("steel_4340", "AISI 4340 steel under impact (Johnson & Cook 1983, 1985).", "johnson_cook",
           {{"density", 7830},
            {"youngs_modulus", 200e9},
            {"poissons_ratio", 0.29},
            {"A", 792e6},
            {"B", 510e6},
            {"n", 0.26},
            {"C", 0.014},
            {"m", 1.03},
            {"melting_temperature", 1793},
            {"heat_capacity", 477},
            {"D1", 0.05},
            {"D2", 3.44},
            {"D3", -2.12},
            {"D4", 0.002},
            {"D5", 0.61}}),
      make("copper_linear", "Copper of the Taylor bar benchmark, with linear hardening (Wilkins & Guinan 1973).", "j2",
           {{"density", 8930}, {"youngs_modulus", 117e9}, {"poissons_ratio", 0.35}, {"yield_stress", 400e6}, {"hardening_modulus", 100e6}}),
      make("snow_dry", "Snow that clumps (Stomakhin et al. 2013).", "snow",
           {{"density", 400},
            {"youngs_modulus", 1.4e5},
            {"poissons_ratio", 0.2},
            {"critical_compression", 0.025},
            {"critical_stretch", 0.0075},
            {"hardening", 10}}),
      make("rubber_treloar", "Vulcanised natural rubber, Treloar's tests (Ogden 1972).", "ogden",
           {{"density", 930},
            {"bulk_modulus", 1e8},
            {"mu_1", 6.3e5},
            {"alpha_1", 1.3},
            {"mu_2", 1.2e3},
            {"alpha_2", 5},
            {"mu_3", -1e4},
            {"alpha_3", -2}}),
      make("aluminium_rods", "The rods of aluminium that stand for soil in two dimensions (Bui et al. 2008).", "mohr_coulomb",
           {{"density", 2650}, {"youngs_modulus", 0.84e6}, {"poissons_ratio", 0.3}, {"cohesion", 0}, {"friction_angle", 19.8}}),
      make("air", "Air at sea level: an ideal gas.", "ideal_gas", {{"density", 1.2}, {"pressure", 101325}, {"gamma", 1.4}}),
      make("water_shock", "Water under shocks: a stiffened gas (Harlow & Amsden 1971).", "stiffened_gas",
           {{"density", 1000}, {"gamma", 4.4}, {"stiff_pressure", 6e8}, {"pressure", 101325}}),
      make("copper_shock", "Copper under shocks, without strength (Zel'dovich & Raizer 1966; Marsh 1980).", "mie_gruneisen",
           {{"density", 8930}, {"sound_speed", 3940}, {"slope", 1.489}, {"gruneisen", 1.99}}),
      make("tnt", "The products of TNT (Lee, Hornig & Kury 1968; Dobratz & Crawford 1985).", "jwl",
           {{"density", 1630}, {"A", 371.2e9}, {"B", 3.231e9}, {"R1", 4.15}, {"R2", 0.95}, {"omega", 0.3}, {"energy", 7e9}}),
  };
  return sets;
}

Input material_table(const Input& input, const ReadContext& context) {
  if (input.kind() != Input::Kind::string) return input;
  std::vector<std::string> names;
  for (const ParameterSet& set : parameter_sets()) {
    if (set.name == input.as_string()) {
      Input table = set.table;
      table.with_place(input.place());
      return table;
    }
    names.push_back(set.name);
  }
  fail_input(input, context,
             fmt::format("material = {} names no parameter set, allowed: {}{}; or give a table {{ type = ... }}", input.text(),
                         list_names(names), did_you_mean(input.as_string(), names)));
}

}  // namespace matpoint
