#include "io/state_file.hpp"

#include <string_view>

#include "core/error.hpp"
#include "io/hdf5_file.hpp"

namespace matpoint {
namespace {

/// With the version of the format: another one is refused.
constexpr const char* k_title = "matpoint state, format 2";
constexpr std::string_view k_any_title = "matpoint state, format ";

}  // namespace

void write_state(const std::filesystem::path& path, const StateTable& table) {
  Hdf5Content content;
  for (const auto& [name, array] : table) {
    Hdf5Array out{name, Number::float64, {}, {}};
    if (const auto* reals = std::get_if<std::vector<double>>(&array)) {
      out.values = std::span<const Real>(*reals);
    } else if (const auto* singles = std::get_if<std::vector<float>>(&array)) {
      out.number = Number::float32;
      out.values = std::span<const float>(*singles);
    } else if (const auto* integers = std::get_if<std::vector<Index>>(&array)) {
      out.number = Number::int64;
      out.values = std::span<const Index>(*integers);
    } else {
      out.number = Number::uint8;
      out.values = std::string_view(std::get<std::string>(array));
    }
    content.arrays.push_back(std::move(out));
  }
  content.title = k_title;
  write_hdf5(path, content);
}

StateTable read_state(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) throw InputError("there is no state \"{}\"", path.string());
  const std::string title = title_of(path);
  if (!title.starts_with(k_any_title)) throw InputError("\"{}\" is no state of matpoint", path.string());
  if (title != k_title) throw InputError("\"{}\" is a \"{}\", and this program reads \"{}\"", path.string(), title, k_title);
  return read_sealed_hdf5(path);
}

}  // namespace matpoint
