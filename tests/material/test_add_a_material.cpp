// docs/add_a_material.md prints two laws: they are the headers that these tests compile, to the letter, so the page cannot go out of date.
#include <filesystem>
#include <fstream>
#include <sstream>

#include "material/law_samples.hpp"

namespace matpoint::test {
namespace {

/// A file of the source tree.
std::string read_source(const std::string& path) {
  const std::filesystem::path tests = std::filesystem::path(MATPOINT_TEST_DATA).parent_path().parent_path();
  std::ifstream file(tests.parent_path() / path);
  EXPECT_TRUE(file.good()) << path;
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(AddAMaterial, page_prints_the_laws_that_the_tests_compile) {
  const std::string page = read_source("docs/add_a_material.md");
  for (const char* header :
       {"tests/material/my_rubber.hpp", "tests/material/damaged_neo_hookean.hpp", "tests/material/perfect_metal.hpp"}) {
    const std::string law = read_source(header);
    EXPECT_GT(law.size(), 500u);
    EXPECT_NE(page.find("```cpp\n" + law + "```\n"), std::string::npos) << header << " and the page differ";
  }
}

TEST(AddAMaterial, page_shows_what_explain_says) {
  const std::string page = read_source("docs/add_a_material.md");
  EXPECT_NE(page.find(std::string("material \"my_rubber\": ") + MyRubber::summary), std::string::npos);
  for (const ParameterDescription& parameter : parameters_of<MyRubber>().describe()) {
    std::istringstream lines(page);
    bool is_shown = false;
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string name, type, unit, rest;
      words >> name >> type >> unit >> rest;
      const std::string given = parameter.is_required ? "required" : parameter.default_text;
      is_shown = is_shown || (name == parameter.name && type == parameter.type && unit == parameter.unit && rest == given &&
                              line.ends_with("  " + parameter.allowed));
    }
    EXPECT_TRUE(is_shown) << parameter.name;
    EXPECT_NE(page.find("      " + parameter.help + "\n"), std::string::npos) << parameter.name;
  }
}

TEST(AddAMaterial, page_names_tests_that_exist) {
  const std::string page = read_source("docs/add_a_material.md");
  const std::string suite = read_source("tests/material/test_all_laws.cpp");
  std::istringstream lines(suite);
  for (std::string line; std::getline(lines, line);) {
    const std::string start = "TYPED_TEST(AllLawsTest, ";
    if (line.rfind(start, 0) != 0) continue;
    const std::string name = line.substr(start.size(), line.find(')') - start.size());
    EXPECT_NE(page.find('`' + name + '`'), std::string::npos) << name << " is not on the page";
  }
}

}  // namespace
}  // namespace matpoint::test
