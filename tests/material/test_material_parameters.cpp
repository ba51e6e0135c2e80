// Materials by name, as case files ask for them: every parameter outside of its range is refused, and the text says what is allowed.
#include "material/law_samples.hpp"
#include "material/material.hpp"

namespace matpoint::test {
namespace {

Input elastic(const std::string& type) {
  Input table = Input::table();
  table.set("type", Input::string(type));
  table.set("density", Input::real(1000));
  table.set("youngs_modulus", Input::real(1e5));
  table.set("poissons_ratio", Input::real(0.3));
  return table;
}
Input fluid() {
  Input table = Input::table();
  table.set("type", Input::string("newtonian_fluid"));
  table.set("density", Input::real(1000));
  table.set("pressure_scale", Input::real(100));
  return table;
}

/// What the registry says to the table, empty for yes.
std::string complaint(const Input& table) {
  try {
    material_registry().read(table, {2, "body \"soil\""}, "material");
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}
std::string complaint(Input table, const std::string& key, Real value) {
  table.set(key, Input::real(value)).with_place("case.toml:14");
  return complaint(table);
}

TEST(MaterialParameters, outside_of_their_range_are_refused_with_place_value_and_range) {
  const std::string place = "case.toml:14: body \"soil\": material: ";
  for (const char* type : {"st_venant_kirchhoff", "neo_hookean"}) {
    EXPECT_EQ(complaint(elastic(type)), "");
    EXPECT_EQ(complaint(elastic(type), "density", 0), place + "density = 0 is not allowed, it must be > 0");
    EXPECT_EQ(complaint(elastic(type), "density", -1000), place + "density = -1000 is not allowed, it must be > 0");
    EXPECT_EQ(complaint(elastic(type), "youngs_modulus", 0), place + "youngs_modulus = 0 is not allowed, it must be > 0");
    const std::string range = " is not allowed, it must be in the open interval (-1, 0.5)";
    for (const char* value : {"0.5", "-1", "0.6", "-1.5"}) {
      EXPECT_EQ(complaint(elastic(type), "poissons_ratio", std::stod(value)), place + "poissons_ratio = " + value + range);
    }
    EXPECT_EQ(complaint(elastic(type), "poissons_ratio", 0.499), "");
    EXPECT_EQ(complaint(elastic(type), "poissons_ratio", -0.999), "");
  }
  EXPECT_EQ(complaint(fluid()), "");
  EXPECT_EQ(complaint(fluid(), "density", 0), place + "density = 0 is not allowed, it must be > 0");
  EXPECT_EQ(complaint(fluid(), "pressure_scale", 0), place + "pressure_scale = 0 is not allowed, it must be > 0");
  EXPECT_EQ(complaint(fluid(), "gamma", 0.5), place + "gamma = 0.5 is not allowed, it must be in the interval [1, 50]");
  EXPECT_EQ(complaint(fluid(), "gamma", 51), place + "gamma = 51 is not allowed, it must be in the interval [1, 50]");
  EXPECT_EQ(complaint(fluid(), "viscosity", -1), place + "viscosity = -1 is not allowed, it must be >= 0");
  for (const Real limit : {1.0, 50.0}) EXPECT_EQ(complaint(fluid(), "gamma", limit), "");
  EXPECT_EQ(complaint(fluid(), "viscosity", 0), "");
}

TEST(MaterialParameters, not_finite_or_no_number_is_refused_for_each_parameter_of_each_law) {
  for (const auto& entry : material_registry().entries()) {
    for (const ParameterDescription& parameter : entry.parameters) {
      if (parameter.type == "string") continue;
      Input table = Input::table();
      table.set("type", Input::string(entry.name));
      table = sample_table(
          entry.parameters, 0,
          [](const Input& input) {
            material_registry().read(input, {2, ""}, "material");
          },
          table);
      EXPECT_EQ(complaint(table), "");
      auto& entries = table.entries();
      entries.erase(std::remove_if(entries.begin(), entries.end(), [&](const auto& e) { return e.first == parameter.name; }),
                    entries.end());
      const std::string text = complaint(table);
      EXPECT_EQ(text.find(parameter.name + " is missing") != std::string::npos, parameter.is_required) << text;
      const std::string not_finite = complaint(table, parameter.name, std::numeric_limits<Real>::infinity());
      EXPECT_NE(not_finite.find(parameter.name + " = inf is not a finite number"), std::string::npos) << not_finite;
      const std::string not_a_number = complaint(table, parameter.name, std::numeric_limits<Real>::quiet_NaN());
      EXPECT_NE(not_a_number.find(parameter.name + " = nan is not a finite number"), std::string::npos) << not_a_number;
      table.set(parameter.name, Input::string("stiff"));
      EXPECT_NE(complaint(table).find(parameter.name + " must be a number, got \"stiff\" (a string)"), std::string::npos)
          << complaint(table);
    }
  }
}

TEST(MaterialParameters, unknown_law_and_unknown_key_offer_the_nearest_name) {
  EXPECT_EQ(complaint(elastic("neo_hooke")), "body \"soil\": material type = \"neo_hooke\" is unknown, allowed: " +
                                                 list_names(material_registry().names()) + "; did you mean \"neo_hookean\"?");
  const std::string text = complaint(elastic("neo_hookean"), "youngs_module", 1);
  EXPECT_EQ(text, "case.toml:14: body \"soil\": material: unknown key \"youngs_module\"; did you mean \"youngs_modulus\"?");
}

}  // namespace
}  // namespace matpoint::test
