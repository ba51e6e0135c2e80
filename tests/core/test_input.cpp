// The input tree and the readers of single values: what they take, what they refuse and with which words.
#include <gtest/gtest.h>

#include <limits>

#include "core/parameters.hpp"

namespace matpoint::test {
namespace {

enum class Color { red, green };

struct Thing {
  Real length = 2;
  int count = 3;
  bool is_open = true;
  std::string label = "none";
  Vec3 point{1, 2, 3};
  std::vector<Real> values;
  std::vector<int> counts;
  std::vector<std::string> words;
  std::vector<Vec3> path;
  std::optional<Real> limit;
  Color color = Color::green;

  static void declare(ParameterTable<Thing>& table) {
    table.required("length", "m", &Thing::length, positive(), "Length.");
    table.optional("count", "1", &Thing::count, at_least(1), "Count.");
    table.optional("is_open", "1", &Thing::is_open, any_number(), "Open.");
    table.optional("label", "1", &Thing::label, any_number(), "Label.");
    table.optional("point", "m", &Thing::point, any_number(), "Point.");
    table.optional("values", "m", &Thing::values, non_negative(), "Values.");
    table.optional("counts", "1", &Thing::counts, at_least(0), "Counts.");
    table.optional("words", "1", &Thing::words, any_number(), "Words.");
    table.optional("path", "m", &Thing::path, any_number(), "Path.");
    table.optional("limit", "m", &Thing::limit, between(0, 1), "Limit.");
    table.choice("color", &Thing::color, {{"red", Color::red}, {"green", Color::green}}, "Color.");
  }
};

Input numbers(const std::vector<Real>& values) {
  Input array = Input::array();
  for (const Real value : values) array.items().push_back(Input::real(value));
  return array;
}
Input with_length() {
  Input table = Input::table();
  table.set("length", Input::real(0.5));
  return table;
}
Thing read(const Input& input, int dim = 2) {
  Thing thing;
  parameters_of<Thing>().read(input, {dim, "thing"}, thing);
  return thing;
}
std::string complaint(const std::string& key, Input value, int dim = 2) {
  Input table = with_length();
  table.set(key, std::move(value)).with_place("a.toml:3");
  try {
    read(table, dim);
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(Parameters, missing_ones_keep_their_default_and_required_ones_are_asked_for) {
  const Thing thing = read(with_length());
  EXPECT_EQ(thing.length, 0.5);
  EXPECT_EQ(thing.count, 3);
  EXPECT_EQ(thing.color, Color::green);
  EXPECT_FALSE(thing.limit.has_value());
  try {
    read(Input::table());
    FAIL() << "should have thrown";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "thing: length is missing (number [m]): Length.");
  }
}

TEST(Parameters, whole_real_numbers_are_integers_and_others_are_refused) {
  EXPECT_EQ(complaint("count", Input::real(1e6)), "");
  const std::string place = "a.toml:3: thing: ";
  EXPECT_EQ(complaint("count", Input::real(1.5)), place + "count must be an integer, got 1.5 (a number)");
  EXPECT_EQ(complaint("count", Input::real(std::numeric_limits<Real>::quiet_NaN())),
            place + "count must be an integer, got nan (a number)");
  EXPECT_EQ(complaint("count", Input::integer(0)), place + "count = 0 is not allowed, it must be >= 1");
  EXPECT_EQ(complaint("count", Input::integer(Index{1} << 40)), place + "count = 1099511627776 is too large");
}

TEST(Parameters, values_of_another_kind_length_or_range_are_refused_with_the_place) {
  const std::string place = "a.toml:3: thing: ";
  EXPECT_EQ(complaint("length", Input::integer(2)), "");
  EXPECT_EQ(complaint("length", Input::string("2 m")), place + "length must be a number, got \"2 m\" (a string)");
  EXPECT_EQ(complaint("length", Input::real(-2)), place + "length = -2 is not allowed, it must be > 0");
  EXPECT_EQ(complaint("length", Input::real(std::numeric_limits<Real>::infinity())), place + "length = inf is not a finite number");
  EXPECT_EQ(complaint("is_open", Input::integer(1)), place + "is_open must be true or false, got 1 (an integer)");
  EXPECT_EQ(complaint("label", Input::integer(1)), place + "label must be a string, got 1 (an integer)");
  EXPECT_EQ(complaint("point", numbers({1, 2, 3})), place + "point = [1, 2, 3] has 3 numbers; the case has dim = 2, so it must have 2");
  EXPECT_EQ(complaint("point", Input::real(1)), place + "point must be an array of 2 numbers, got 1 (a number)");
  EXPECT_EQ(complaint("limit", Input::real(1)), place + "limit = 1 is not allowed, it must be in the open interval (0, 1)");
  EXPECT_EQ(complaint("color", Input::string("grene")),
            place + "color = \"grene\" is unknown, allowed: \"red\" or \"green\"; did you mean \"green\"?");
  EXPECT_EQ(complaint("lenght", Input::real(1)), place + "unknown key \"lenght\"; did you mean \"length\"?");
  // Items of an array carry no place of their own here; the index says which one is meant.
  EXPECT_NE(complaint("values", numbers({1, -1})).find("values[1] = -1 is not allowed, it must be >= 0"), std::string::npos);
  EXPECT_NE(complaint("counts", numbers({1, 2.5})).find("counts[1] must be an integer, got 2.5"), std::string::npos);
}

TEST(Parameters, written_values_read_back_as_the_same) {
  for (const int dim : {2, 3}) {
    Thing thing;
    thing.length = 0.1;
    thing.count = 12;
    thing.is_open = false;
    thing.label = "with \"quotes\"";
    thing.point = {0.25, -3, dim == 3 ? 1e-30 : 0};
    thing.values = {1, 2.5};
    thing.counts = {4};
    thing.words = {"a", "b"};
    thing.path = {{1, 2, 0}, {3, 4, 0}};
    thing.limit = 0.5;
    thing.color = Color::red;
    const Thing again = read(parameters_of<Thing>().write(thing, dim), dim);
    EXPECT_EQ(again.length, thing.length);
    EXPECT_EQ(again.count, thing.count);
    EXPECT_EQ(again.is_open, thing.is_open);
    EXPECT_EQ(again.label, thing.label);
    EXPECT_EQ(again.point, thing.point);
    EXPECT_EQ(again.values, thing.values);
    EXPECT_EQ(again.counts, thing.counts);
    EXPECT_EQ(again.words, thing.words);
    EXPECT_EQ(again.path, thing.path);
    EXPECT_EQ(again.limit, thing.limit);
    EXPECT_EQ(again.color, thing.color);
  }
}

TEST(Parameters, descriptions_hold_unit_type_default_range_and_help) {
  const std::vector<ParameterDescription> all = parameters_of<Thing>().describe();
  ASSERT_EQ(all.size(), 11u);
  EXPECT_EQ(all[0].name + "|" + all[0].unit + "|" + all[0].type + "|" + all[0].default_text + "|" + all[0].allowed + "|" + all[0].help,
            "length|m|number||> 0|Length.");
  EXPECT_TRUE(all[0].is_required);
  EXPECT_EQ(all[1].default_text, "3");
  EXPECT_EQ(all[1].type, "integer");
  EXPECT_EQ(all[9].default_text, "") << "an empty optional has no default";
  EXPECT_EQ(all[9].type, "number");
  EXPECT_EQ(all[10].default_text, "\"green\"");
  EXPECT_EQ(all[10].allowed, "\"red\" or \"green\"");
}

TEST(Constraints, hold_at_and_around_their_limits) {
  EXPECT_FALSE(positive().holds(0));
  EXPECT_TRUE(positive().holds(1e-300));
  EXPECT_TRUE(non_negative().holds(0));
  EXPECT_FALSE(non_negative().holds(-1e-300));
  EXPECT_TRUE(at_least(2).holds(2));
  EXPECT_FALSE(at_least(2).holds(1.999));
  EXPECT_FALSE(between(0, 1).holds(0));
  EXPECT_FALSE(between(0, 1).holds(1));
  EXPECT_TRUE(between(0, 1).holds(0.5));
  EXPECT_TRUE(between_closed(0, 1).holds(0));
  EXPECT_TRUE(between_closed(0, 1).holds(1));
  EXPECT_FALSE(between_closed(0, 1).holds(1.001));
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  for (const Constraint& constraint : {positive(), non_negative(), at_least(0), between(0, 1), between_closed(0, 1)}) {
    EXPECT_FALSE(constraint.holds(nan)) << constraint.text;
  }
}

TEST(Input, texts_are_those_of_a_case_file_and_long_ones_are_cut) {
  EXPECT_EQ(Input::boolean(true).text(), "true");
  EXPECT_EQ(Input::integer(-3).text(), "-3");
  EXPECT_EQ(Input::real(0.1).text(), "0.1");
  EXPECT_EQ(Input::string("a").text(), "\"a\"");
  EXPECT_EQ(numbers({1, 2.5}).text(), "[1, 2.5]");
  EXPECT_EQ(Input::table().text(), "{...}");
  EXPECT_LE(Input::string(std::string(1000, 'x')).text().size(), 63u);
  EXPECT_LE(numbers(std::vector<Real>(1000, 1)).text().size(), 63u);
  EXPECT_EQ(numbers({}).kind_text(), "an array");
}

TEST(Input, set_replaces_and_find_finds) {
  Input table = Input::table();
  table.set("a", Input::integer(1));
  table.set("b", Input::integer(2));
  table.set("a", Input::integer(3));
  EXPECT_EQ(table.entries().size(), 2u);
  EXPECT_EQ(table.find("a")->as_integer(), 3);
  EXPECT_EQ(table.find("c"), nullptr);
  EXPECT_EQ(Input::integer(4).as_real(), 4);
}

}  // namespace
}  // namespace matpoint::test
