// Valid cases with random damage: each is accepted or refused by an InputError of one line, and nothing else ever happens.
#include <random>

#include "case/wrong_input.hpp"

namespace matpoint::test {
namespace {

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  std::string word;
  for (const char c : text) {
    const bool is_word = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-';
    if (is_word) {
      word += c;
      continue;
    }
    if (!word.empty()) words.push_back(word);
    words.emplace_back(1, c);
    word.clear();
  }
  if (!word.empty()) words.push_back(word);
  return words;
}

class Mutations : public testing::TestWithParam<int> {};

TEST_P(Mutations, are_accepted_or_refused_in_one_line) {
  const std::vector<std::string> odd = {"0",   "-1",      "1e308", "-1e308",     "5e-324",  "nan",   "inf",        "9223372036854775807",
                                        "0.3", "\"\"",    "[]",    "{}",         "true",    "[[1]]", "2147483647", "\"x\"",
                                        "\n",  "]",       "}",     "[",          "{",       "=",     ",",          "\xc3",
                                        "\"",  "polygon", "union", "half_space", "velocity"};
  std::mt19937 random(static_cast<unsigned>(GetParam()));
  const std::vector<std::string> valid = words_of(GetParam() % 2 == 0 ? k_case : k_case_3d);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  int refused = 0;
  for (int n = 0; n < 500; ++n) {
    std::vector<std::string> words = valid;
    for (std::size_t k = 0; k <= below(2); ++k) {
      std::string& word = words[below(words.size())];
      switch (below(4)) {
        case 0: word.clear(); break;
        case 1: word = odd[below(odd.size())]; break;
        case 2: word = words[below(words.size())]; break;
        default: word.resize(below(word.size() + 1)); break;
      }
    }
    std::string text;
    for (const std::string& word : words) text += word;
    const std::string message = message_of<InputError>([&] { Case::from_input(parse_toml(text, "case.toml"), "case"); });
    if (message == "no exception") continue;
    ++refused;
    EXPECT_FALSE(message.starts_with("another exception")) << message << "\n" << text;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), 600u) << message;
  }
  EXPECT_GT(refused, 100) << "the damage should be damage";
}

INSTANTIATE_TEST_SUITE_P(seeds, Mutations, testing::Range(0, 8));

}  // namespace
}  // namespace matpoint::test
