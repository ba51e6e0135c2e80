// Texts that are no TOML, files that are no cases, and --set that names nothing.
#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <random>
#include <thread>

#include "case/wrong_input.hpp"

namespace matpoint::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class NotToml : public testing::TestWithParam<WrongInput> {};
TEST_P(NotToml, is_refused_with_the_line) { expect_refused(k_case, GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    syntax, NotToml,
    testing::Values(WrongInput{"no_value", "damping = 0", "damping =", {"not valid TOML: "}},
                    WrongInput{"no_equals", "damping = 0", "damping 0", {"not valid TOML: "}},
                    WrongInput{"two_values", "damping = 0", "damping = 0 1", {"not valid TOML: "}},
                    WrongInput{"word", "damping = 0", "damping = none", {"not valid TOML: "}},
                    WrongInput{"comma_for_a_point", "damping = 0", "damping = 0,5", {"not valid TOML: "}},
                    WrongInput{"point_without_digit", "damping = 0", "damping = .5", {"not valid TOML: "}},
                    WrongInput{"endless_string", "title = \"A block falls\"", "title = \"A block falls", {"not valid TOML: "}},
                    WrongInput{"endless_section", "[solver]", "[solver", {"not valid TOML: "}},
                    WrongInput{"key_twice", "damping = 0", "damping = 0\n@damping = 1", {"not valid TOML: ", "damping"}},
                    WrongInput{"section_twice", "[output]", "[time]", {"not valid TOML: ", "time"}},
                    WrongInput{"integer_too_large", "damping = 0", "damping = 99999999999999999999", {"not valid TOML: "}},
                    WrongInput{"control_character", "damping = 0", "damping = 0 # \x01", {"not valid TOML: "}},
                    WrongInput{"not_utf8", "title = \"A block falls\"", "title = \"\xff\xfe\"", {"not valid TOML: "}},
                    WrongInput{"deep_nesting", "damping = 0", "damping = " + std::string(10000, '['), {"not valid TOML: "}}),
    name_of);

TEST(NotACase, empty_text_lacks_everything) { EXPECT_THAT(refusal(""), StartsWith("case.toml: grid is missing (table)")); }

TEST(NotACase, other_languages_are_refused_with_the_line) {
  EXPECT_THAT(refusal("{\n  \"grid\": {}\n}\n"), StartsWith("case.toml:1: not valid TOML: "));
  EXPECT_THAT(refusal("grid:\n  upper: [1, 1]\n"), StartsWith("case.toml:1: not valid TOML: "));
  EXPECT_THAT(refusal("<case>\n</case>\n"), StartsWith("case.toml:1: not valid TOML: "));
  EXPECT_THAT(refusal(std::string("\x7f"
                                  "ELF\x02\x01\x01\0\0\0",
                                  10)),
              StartsWith("case.toml:1: not valid TOML: "));
}

/// Files of a test, and what loading one says.
class CaseFile : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder.path() / name, std::ios::binary) << text;
    return (folder.path() / name).string();
  }
  static std::string load(const std::string& name, const std::vector<std::string>& sets = {}) {
    return message_of<InputError>([&] { load_case(name, sets); });
  }
  TemporaryFolder folder;
};

TEST_F(CaseFile, megabytes_of_noise_are_refused_in_seconds_with_a_short_message) {
  std::mt19937 random(1);
  std::string bytes(10'000'000, ' ');
  for (char& c : bytes) c = static_cast<char>(random());
  std::string letters = bytes;
  for (char& c : letters) c = static_cast<char>(' ' + static_cast<unsigned char>(c) % 95);
  std::string keys;
  for (int k = 0; keys.size() < 2'000'000; ++k) keys += fmt::format("key_{} = {}\n", k, k);
  std::string numbers = "gravity = [";
  while (numbers.size() < 2'000'000) numbers += "1.5, ";
  const auto start = std::chrono::steady_clock::now();
  for (const std::string& text : {bytes, letters, keys, numbers + "0]", "title = \"" + letters, std::string(10'000'000, '[')}) {
    const std::string message = load(write("noise.toml", text));
    EXPECT_THAT(message, StartsWith((folder.path() / "noise.toml").string()));
    EXPECT_LT(message.size(), 600u);
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60)) << "this need not take longer";
}

TEST_F(CaseFile, empty_file_lacks_everything) {
  const std::string file = write("empty.toml", "");
  EXPECT_THAT(load(file), StartsWith(file + ": grid is missing (table)"));
}

TEST_F(CaseFile, folder_is_refused) {
  const std::string path = folder.path().string();
  EXPECT_EQ(load(path), fmt::format("\"{}\" is a folder; give a case file", path));
}

TEST_F(CaseFile, missing_file_is_refused_with_the_nearest_shipped_case) {
  EXPECT_EQ(load("diks"),
            "there is no file and no shipped case \"diks\"; did you mean \"disks\"? (`matpoint list cases` names the shipped ones)");
  EXPECT_THAT(load("diks.toml"), AllOf(HasSubstr("\"diks.toml\""), HasSubstr("did you mean \"disks\"?")));
  EXPECT_THAT(load((folder.path() / "disks.toml").string()), StartsWith("there is no file and no shipped case"));
  EXPECT_THAT(load(""), StartsWith("there is no file and no shipped case \"\""));
  EXPECT_THAT(load("a\nb"), HasSubstr("\"a?b\""));
}

TEST_F(CaseFile, file_without_end_is_refused) {
  EXPECT_THAT(load("/dev/zero"), StartsWith("\"/dev/zero\" has more than 16 MB; that must be a mistake"));
}

TEST_F(CaseFile, pipe_is_read_like_a_file) {
  const std::string pipe = (folder.path() / "pipe.toml").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe) << k_case; });
  EXPECT_EQ(load_case(pipe).bodies.size(), 1u);
  writer.join();
}

TEST_F(CaseFile, is_preferred_to_the_shipped_case_of_its_name_and_gives_its_stem) {
  EXPECT_EQ(load_case("disks").name, "disks");
  EXPECT_EQ(load_case("disks.toml").name, "disks");
  const Case own = load_case(write("disks.toml", k_case));
  EXPECT_EQ(own.name, "disks");
  EXPECT_EQ(own.title, "A block falls");
}

TEST_F(CaseFile, places_name_the_file_as_given) {
  const std::string file = write("ball.toml", "gravity = [0, -10]\n[grid]\nuper = [1, 1]\n");
  EXPECT_EQ(load(file), file + ":3: grid: unknown key \"uper\"; did you mean \"upper\"?");
}

// --- --set -----------------------------------------------------------------------------------------------------------

struct WrongSet {
  std::string name;
  std::string set;
  std::string beginning;
  std::string part;
};

void PrintTo(const WrongSet& wrong, std::ostream* out) { *out << wrong.name; }

class SetOption : public testing::TestWithParam<WrongSet> {};
TEST_P(SetOption, is_refused_in_words) {
  const std::string message = refusal(k_case, {GetParam().set});
  EXPECT_THAT(message, AllOf(StartsWith(GetParam().beginning), HasSubstr(GetParam().part)));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    wrong, SetOption,
    testing::Values(
        WrongSet{"no_equals", "time.end", "--set time.end: ", "expected KEY=VALUE, e.g. --set solver.flip=0.99"},
        WrongSet{"no_key", "=1", "--set =1: ", "expected KEY=VALUE"}, WrongSet{"empty", "", "--set : ", "expected KEY=VALUE"},
        WrongSet{"empty_part", "time..end=1", "--set time..end: ", "the key has an empty part"},
        WrongSet{"first_part_empty", ".end=1", "--set .end: ", "the key has an empty part"},
        WrongSet{"last_part_empty", "time.end.=1", "--set time.end.: ", "the key has an empty part"},
        WrongSet{"trailing_dot", "title2.=1", "--set title2.: ", "the key has an empty part"},
        WrongSet{"below_a_number", "time.end.x=1",
                 "--set time.end.x: ", "\"x\" stands below 0.01, which is no table; set that value as a whole"},
        WrongSet{"entry_of_a_vector", "gravity.1=5",
                 "--set gravity.1: ", "\"1\" stands below [0, -10], which is no table; set that value as a whole"},
        WrongSet{"unknown_key", "solver.flop=1", "--set solver.flop: solver: ", "unknown key \"flop\"; did you mean \"flip\"?"},
        WrongSet{"unknown_section", "sovler.flip=1", "--set sovler.flip: ", "unknown key \"sovler\"; did you mean \"solver\"?"},
        WrongSet{"number_for_a_list", "body=3", "--set body: ", "body must be a list of tables [[body]], got 3 (an integer)"},
        WrongSet{"unknown_body", "body.blok.name=x",
                 "--set body.blok.name: ", "there is no \"blok\"; give \"block\" or a number from 1 to 1; did you mean \"block\"?"},
        WrongSet{"index_zero", "body.0.name=x", "--set body.0.name: ", "there is no \"0\"; give \"block\" or a number from 1 to 1"},
        WrongSet{"index_out_of_range", "boundary.2.kind=fixed", "--set boundary.2.kind: ", "there is no \"2\"; give a number from 1 to 1"},
        WrongSet{"index_huge", "boundary.99999999999999999999.kind=fixed", "--set boundary.", "give a number from 1 to 1"},
        WrongSet{"whole_entry", "body.block=1", "--set body.block: ", "names a whole entry; name a key in it, e.g. body.block.name"},
        WrongSet{"wrong_value", "solver.flip=2",
                 "--set solver.flip: solver: ", "flip = 2 is not allowed, it must be in the interval [0, 1]"},
        WrongSet{"word_for_a_number", "time.end=soon", "--set time.end: time: ", "end must be a number, got \"soon\" (a string)"},
        WrongSet{"nothing_for_a_number", "time.end=", "--set time.end: time: ", "end must be a number, got \"\" (a string)"},
        WrongSet{"unit_behind_a_number", "time.end=5 s", "--set time.end: time: ", "end must be a number, got \"5 s\" (a string)"},
        WrongSet{"date", "time.end=2020-01-01", "--set time.end: time: ", "end must be a number, got \"2020-01-01\" (a string)"},
        WrongSet{"half_an_array", "gravity=[0, -10",
                 "--set gravity: ", "gravity must be an array of 2 numbers, got \"[0, -10\" (a string)"},
        WrongSet{"line_break", "time.end=1\nx = 2", "--set time.end: time: ", "end must be a number, got \"1?x = 2\""},
        WrongSet{"not_utf8", "title=\xff", "--set: ", "KEY=VALUE is not valid UTF-8"},
        WrongSet{"not_utf8_cut", "title=\xe2\x82", "--set: ", "KEY=VALUE is not valid UTF-8"},
        WrongSet{"table_for_a_number", "time.end={ s = 1 }", "--set time.end: time: ", "end must be a number, got {...} (a table)"},
        WrongSet{"in_a_material", "body.block.material.density=-1",
                 "--set body.block.material.density: body \"block\": material: ", "density = -1 is not allowed, it must be > 0"}),
    [](const auto& parameter) { return parameter.param.name; });

TEST(Set, below_an_empty_list_is_refused) {
  EXPECT_EQ(refusal("body = []\n", {"body.block.name=x"}), "--set body.block.name: there is no \"block\", the list is empty");
}

Input with(const std::vector<std::string>& sets) {
  Input input = parse_toml(k_case, "case.toml");
  for (const std::string& set : sets) apply_set(input, set);
  return input;
}

TEST(Set, takes_values_of_every_kind) {
  const Input input =
      with({"a=1",     "b=1.5",  "c=1e3",  "d=true", "e=\"quoted = text\"", "f=plain", "g=two words", "h=[1, [2, 3]]", "i={ x = 1 }",
            "j=",      "k=-inf", "l=0x10", "m=a=b",  "n=2020-01-01",        "o=µm",    "p=.3",        "q=-.5e1",       "r=+2.",
            "s=1.2.3", "t=.",    "u=007"});
  EXPECT_EQ(input.find("a")->kind(), Input::Kind::integer);
  EXPECT_EQ(input.find("b")->as_real(), 1.5);
  EXPECT_EQ(input.find("c")->kind(), Input::Kind::real);
  EXPECT_TRUE(input.find("d")->as_boolean());
  EXPECT_EQ(input.find("e")->as_string(), "quoted = text");
  EXPECT_EQ(input.find("f")->as_string(), "plain");
  EXPECT_EQ(input.find("g")->as_string(), "two words");
  EXPECT_EQ(input.find("h")->items()[1].items()[0].as_integer(), 2);
  EXPECT_EQ(input.find("i")->find("x")->as_integer(), 1);
  EXPECT_EQ(input.find("j")->as_string(), "");
  EXPECT_EQ(input.find("k")->as_real(), -std::numeric_limits<Real>::infinity());
  EXPECT_EQ(input.find("l")->as_integer(), 16);
  EXPECT_EQ(input.find("m")->as_string(), "a=b");
  EXPECT_EQ(input.find("n")->as_string(), "2020-01-01");
  EXPECT_EQ(input.find("o")->as_string(), "µm");
  EXPECT_EQ(input.find("p")->as_real(), 0.3);
  EXPECT_EQ(input.find("q")->as_real(), -5);
  EXPECT_EQ(input.find("r")->as_real(), 2);
  EXPECT_EQ(input.find("s")->as_string(), "1.2.3");
  EXPECT_EQ(input.find("t")->as_string(), ".");
  EXPECT_EQ(input.find("u")->as_string(), "007");
}

TEST(Set, reaches_entries_of_lists_by_name_and_by_number_and_makes_sections) {
  const Case problem = Case::from_input(
      with({"body.block.material.density=7", "body.1.layout.count=9", "boundary.1.kind=fixed", "probe.tip.particle=3", "output.grid=true"}),
      "case");
  EXPECT_EQ(problem.bodies[0].material->density(), 7);
  EXPECT_EQ(write_toml(problem.bodies[0].layout->write(2)), "type = \"per_cell\"\ncount = [3, 3]\n");
  EXPECT_EQ(problem.boundaries[0].kind, BoundaryKind::fixed);
  EXPECT_EQ(problem.probes[0].particle, 3);
  EXPECT_TRUE(problem.output.grid);
  Input bare = parse_toml("title = \"x\"\n", "case.toml");
  apply_set(bare, "solver.flip=0.5");
  EXPECT_EQ(bare.find("solver")->find("flip")->as_real(), 0.5);
}

TEST(Set, of_several_the_last_one_holds) { EXPECT_EQ(with({"time.end=1", "time.end=2"}).find("time")->find("end")->as_integer(), 2); }

}  // namespace
}  // namespace matpoint::test
