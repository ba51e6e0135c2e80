// Names in messages: the nearest known name, and lists.
#include "core/error.hpp"

#include <gtest/gtest.h>

namespace matpoint::test {
namespace {

const std::vector<std::string> k_names = {"youngs_modulus", "poissons_ratio", "density", "viscosity"};

TEST(NearestName, is_found_over_swapped_missing_and_added_letters_and_case) {
  EXPECT_EQ(nearest_name("youngs_modlus", k_names), "youngs_modulus");
  EXPECT_EQ(nearest_name("yuongs_modulus", k_names), "youngs_modulus");
  EXPECT_EQ(nearest_name("poisson_ratio", k_names), "poissons_ratio");
  EXPECT_EQ(nearest_name("densityy", k_names), "density");
  EXPECT_EQ(nearest_name("DENSITY", k_names), "density");
  EXPECT_EQ(nearest_name("viscosity", k_names), "viscosity");
}

TEST(NearestName, takes_the_nearest_of_several_and_the_first_of_equals) {
  EXPECT_EQ(nearest_name("stop", {"steps", "stops", "start"}), "stops");
  EXPECT_EQ(nearest_name("cat", {"bat", "hat"}), "bat");
}

TEST(NearestName, offers_a_name_that_contains_the_word) {
  EXPECT_EQ(nearest_name("young", k_names), "youngs_modulus");
  EXPECT_EQ(nearest_name("ratio", k_names), "poissons_ratio");
}

TEST(NearestName, is_empty_for_words_that_nobody_can_have_meant) {
  EXPECT_EQ(nearest_name("colour", k_names), "");
  EXPECT_EQ(nearest_name("xy", k_names), "");
  EXPECT_EQ(nearest_name("anything", {}), "");
  EXPECT_EQ(nearest_name(std::string(65, 'd'), {std::string(66, 'd')}), "") << "noise, not a typing error";
}

TEST(Messages, hint_and_list_read_as_sentences) {
  EXPECT_EQ(did_you_mean("densty", k_names), "; did you mean \"density\"?");
  EXPECT_EQ(did_you_mean("colour", k_names), "");
  EXPECT_EQ(list_names({}), "");
  EXPECT_EQ(list_names({"a"}), "\"a\"");
  EXPECT_EQ(list_names({"a", "b"}), "\"a\" or \"b\"");
  EXPECT_EQ(list_names({"a", "b", "c"}), "\"a\", \"b\" or \"c\"");
}

TEST(Messages, errors_are_formatted_and_keep_braces_of_plain_text) {
  EXPECT_STREQ(InputError("{} = {} is wrong", "x", 0.5).what(), "x = 0.5 is wrong");
  EXPECT_STREQ(SolverError("step {}", 7).what(), "step 7");
  EXPECT_STREQ(InputError(std::string("a table { }")).what(), "a table { }");
}

}  // namespace
}  // namespace matpoint::test
