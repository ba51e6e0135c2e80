#include "case/case_file.hpp"

#include <toml++/toml.h>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace matpoint {
namespace {

constexpr std::uintmax_t k_file_size_max = 16u << 20;  // of numbers, 100 times that in memory

std::string place_of(const std::string& file, const toml::source_region& source) {
  return source.begin.line > 0 ? fmt::format("{}:{}", file, source.begin.line) : file;
}

Input convert(const toml::node& node, const std::string& file) {
  const std::string place = place_of(file, node.source());
  if (const toml::table* table = node.as_table()) {
    Input result = Input::table();
    // In the order of the file, which toml++ does not keep: the first of several mistakes is the one to report.
    std::vector<std::pair<std::string, const toml::node*>> entries;
    for (const auto& [key, value] : *table) entries.emplace_back(std::string(key.str()), &value);
    std::stable_sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) {
      const auto& x = a.second->source().begin;
      const auto& y = b.second->source().begin;
      return x.line != y.line ? x.line < y.line : x.column < y.column;
    });
    // Keys of TOML are unique; Input::set would look for each of them among all others.
    for (const auto& [key, value] : entries) result.entries().emplace_back(key, convert(*value, file));
    return result.with_place(place);
  }
  if (const toml::array* array = node.as_array()) {
    Input result = Input::array();
    for (const toml::node& item : *array) result.items().push_back(convert(item, file));
    return result.with_place(place);
  }
  if (const auto* value = node.as_boolean()) return Input::boolean(value->get()).with_place(place);
  if (const auto* value = node.as_integer()) return Input::integer(value->get()).with_place(place);
  if (const auto* value = node.as_floating_point()) return Input::real(value->get()).with_place(place);
  if (const auto* value = node.as_string()) return Input::string(value->get()).with_place(place);
  throw InputError("{}: dates and times are not used in case files; times are numbers in seconds", place);
}

// --- writing ---------------------------------------------------------------------------------------------------------

/// Whether all bytes form characters of UTF-8, as far as counting their bytes tells.
bool is_utf8(const std::string& text) {
  std::size_t continuing = 0;
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    if (((u & 0xc0) == 0x80) != (continuing > 0)) return false;
    if (continuing > 0)
      --continuing;
    else if (u >= 0xf8)
      return false;
    else
      continuing = u >= 0xf0 ? 3 : u >= 0xe0 ? 2 : u >= 0xc0 ? 1 : 0;
  }
  return continuing == 0;
}

std::string string_text(const std::string& value) {
  // A command line or a file name may hold any bytes, TOML only characters.
  const bool is_text = is_utf8(value);
  std::string text = "\"";
  for (const char c : value) {
    const auto u = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      text += std::string("\\") + c;
    else if (u < 0x20 || u == 0x7f)
      text += fmt::format("\\u{:04X}", u);
    else if (u >= 0x80 && !is_text)
      text += "\\uFFFD";
    else
      text += c;
  }
  return text + '"';
}

std::string real_text(Real value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  std::string text = fmt::format("{}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string key_text(const std::string& key) {
  const auto is_plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-'; };
  return !key.empty() && std::all_of(key.begin(), key.end(), is_plain) ? key : string_text(key);
}

std::string inline_text(const Input& input) {
  switch (input.kind()) {
    case Input::Kind::boolean: return input.as_boolean() ? "true" : "false";
    case Input::Kind::integer: return fmt::format("{}", input.as_integer());
    case Input::Kind::real: return real_text(input.as_real());
    case Input::Kind::string: return string_text(input.as_string());
    case Input::Kind::array: {
      std::string text = "[";
      for (std::size_t i = 0; i < input.items().size(); ++i) text += (i > 0 ? ", " : "") + inline_text(input.items()[i]);
      return text + "]";
    }
    case Input::Kind::object: throw InputError("{} has no place in a case file", input.text());
    case Input::Kind::table: break;
  }
  std::string text;
  for (const auto& [key, value] : input.entries()) text += (text.empty() ? " " : ", ") + key_text(key) + " = " + inline_text(value);
  return "{" + text + (text.empty() ? "}" : " }");
}

bool is_table_list(const Input& input) {
  return input.kind() == Input::Kind::array && !input.items().empty() &&
         std::all_of(input.items().begin(), input.items().end(), [](const Input& item) { return item.kind() == Input::Kind::table; });
}

/// Things with a type read best on one line.
bool is_inline(const Input& input) {
  if (input.kind() == Input::Kind::table) return input.find("type") != nullptr && input.find("stress_order") == nullptr;
  return !is_table_list(input) || is_inline(input.items().front());
}

void write_table(const Input& table, const std::string& path, std::string& text) {
  for (const auto& [key, value] : table.entries()) {
    if (is_inline(value)) text += key_text(key) + " = " + inline_text(value) + "\n";
  }
  for (const auto& [key, value] : table.entries()) {
    if (is_inline(value)) continue;
    const std::string inner = path.empty() ? key_text(key) : path + "." + key_text(key);
    if (value.kind() == Input::Kind::table) {
      text += "\n[" + inner + "]\n";
      write_table(value, inner, text);
    } else {
      for (const Input& item : value.items()) {
        text += "\n[[" + inner + "]]\n";
        write_table(item, inner, text);
      }
    }
  }
}

// --- --set -----------------------------------------------------------------------------------------------------------

std::vector<std::string> split_path(const std::string& path) {
  std::vector<std::string> words;
  std::size_t begin = 0;
  for (std::size_t dot = path.find('.'); dot != std::string::npos; dot = path.find('.', begin)) {
    words.push_back(path.substr(begin, dot - begin));
    begin = dot + 1;
  }
  words.push_back(path.substr(begin));
  return words;
}

/// The value as TOML, or the text itself as a string: `--set grid.particles_outside=stop` needs no quotes.
Input set_value(const std::string& text, const std::string& place) {
  if (text.find('\n') == std::string::npos) {
    try {
      const toml::table parsed = toml::parse("value = " + text);
      const toml::node& value = *parsed.get("value");
      const bool is_date = value.is_date() || value.is_time() || value.is_date_time();
      if (!is_date) return convert(value, place);
    } catch (const toml::parse_error&) {
      // Not TOML: a plain word, or a number as people write it.
    }
  }
  // TOML wants a digit on both sides of the point: `--set poissons_ratio=.3` is meant all the same.
  Real number = 0;
  const char* const end = text.data() + text.size();
  const char* const begin = text.data() + (text.starts_with('+') ? 1 : 0);
  if (text.find('.') != std::string::npos && std::from_chars(begin, end, number).ptr == end) return Input::real(number);
  return Input::string(text);
}

/// A key of the table, for an example.
std::string key_in(const Input& table) { return table.entries().empty() ? "KEY" : table.entries().front().first; }

/// All places below `input` become the one of the option.
void set_place(Input& input, const std::string& place) {
  input.with_place(place);
  for (Input& item : input.items()) set_place(item, place);
  for (auto& [key, value] : input.entries()) set_place(value, place);
}

/// The item of a list that `word` names: by its name, or by its number from 1.
Input& find_item(Input& list, const std::string& word, const std::string& place) {
  std::vector<std::string> names;
  for (Input& item : list.items()) {
    const Input* name = item.kind() == Input::Kind::table ? item.find("name") : nullptr;
    if (name == nullptr || name->kind() != Input::Kind::string) continue;
    if (name->as_string() == word) return item;
    names.push_back(name->as_string());
  }
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error == std::errc{} && end == word.data() + word.size() && number >= 1 && number <= list.items().size())
    return list.items()[number - 1];
  if (list.items().empty()) throw InputError("{}: there is no \"{}\", the list is empty", place, printable(word));
  throw InputError("{}: there is no \"{}\"; give {}{}a number from 1 to {}{}", place, printable(word), list_names(names),
                   names.empty() ? "" : " or ", list.items().size(), did_you_mean(word, names));
}

// --- files -----------------------------------------------------------------------------------------------------------

/// A pipe is as good as a file, but one that never ends is not.
std::string read_text(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string text;
  std::vector<char> block(1 << 16);
  while (stream && text.size() <= k_file_size_max) {
    stream.read(block.data(), static_cast<std::streamsize>(block.size()));
    text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
  }
  if (text.size() > k_file_size_max) {
    throw InputError("\"{}\" has more than {} MB; that must be a mistake, a case file has a few kB", path.string(), k_file_size_max >> 20);
  }
  if (!stream.eof()) throw InputError("cannot read \"{}\": {}", path.string(), std::strerror(errno));
  return text;
}

}  // namespace

Input parse_toml(const std::string& text, const std::string& file) {
  try {
    return convert(toml::parse(text), file).with_place(file);
  } catch (const toml::parse_error& error) {
    throw InputError("{}: not valid TOML: {}", place_of(file, error.source()), printable(error.description()));
  }
}

std::string write_toml(const Input& input) {
  std::string text;
  write_table(input, "", text);
  return text;
}

void apply_set(Input& input, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw InputError("--set {}: expected KEY=VALUE, e.g. --set solver.flip=0.99", printable(assignment));
  }
  const std::string path = assignment.substr(0, equals);
  const std::string place = "--set " + printable(path);
  if (!is_utf8(assignment)) throw InputError("--set: KEY=VALUE is not valid UTF-8, as the texts of a case must be");
  const std::vector<std::string> words = split_path(path);
  Input* target = &input;
  for (std::size_t w = 0; w < words.size(); ++w) {
    const bool is_last = w + 1 == words.size();
    if (words[w].empty()) throw InputError("{}: the key has an empty part", place);
    if (target->kind() == Input::Kind::array && (target->items().empty() || target->items().front().kind() == Input::Kind::table)) {
      target = &find_item(*target, words[w], place);
      if (is_last) throw InputError("{}: names a whole entry; name a key in it, e.g. {}.{}", place, printable(path), key_in(*target));
      continue;
    }
    if (target->kind() != Input::Kind::table) {
      throw InputError("{}: \"{}\" stands below {}, which is no table; set that value as a whole", place, printable(words[w]),
                       target->text());
    }
    if (is_last) {
      Input value = set_value(assignment.substr(equals + 1), place);
      set_place(value, place);
      target->set(words[w], std::move(value));
      return;
    }
    Input* next = target->find(words[w]);
    target = next != nullptr ? next : &target->set(words[w], Input::table().with_place(place));
  }
}

CaseText find_case(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path path(name);
  const std::string stem = path.stem().string();
  if (!fs::exists(path, ignored)) {
    const auto shipped = shipped_cases().find(path.has_parent_path() || path.extension() != ".toml" ? name : stem);
    if (shipped != shipped_cases().end()) return {shipped->second, shipped->first + ".toml", shipped->first};
    std::vector<std::string> names;
    for (const auto& [known, text] : shipped_cases()) names.push_back(known);
    throw InputError("there is no file and no shipped case \"{}\"{} (`matpoint list cases` names the shipped ones)", printable(name),
                     did_you_mean(stem, names));
  }
  if (fs::is_directory(path, ignored)) throw InputError("\"{}\" is a folder; give a case file", name);
  return {read_text(path), name, stem};
}

Case load_case(const std::string& name, const std::vector<std::string>& sets) {
  const CaseText found = find_case(name);
  Input input = parse_toml(found.text, found.file);
  for (const std::string& set : sets) apply_set(input, set);
  return Case::from_input(input, found.name);
}

}  // namespace matpoint
