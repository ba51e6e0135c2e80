#include "io/state_file.hpp"

#include <bit>
#include <cstring>

#include "core/error.hpp"
#include "io/hdf5_file.hpp"

namespace matpoint {
namespace {

/// Of the format. Another one is refused.
constexpr Index k_version = 1;
constexpr const char* k_version_name = "matpoint_state_version";
constexpr const char* k_checksum_name = "checksum";

/// Of names and bits, to find what has been cut short or changed by accident. FNV-1a by words of 8 bytes.
class Checksum {
 public:
  void add(const void* data, std::size_t size) {
    const char* next = static_cast<const char*>(data);
    for (; size > 0;) {
      std::uint64_t word = 0;
      const std::size_t step = std::min(size, sizeof word);
      std::memcpy(&word, next, step);
      sum_ = std::rotl((sum_ ^ word) * 0x100000001b3u, 29);
      next += step;
      size -= step;
    }
  }
  Index value() const { return std::bit_cast<Index>(sum_); }

 private:
  std::uint64_t sum_ = 0xcbf29ce484222325u;
};

Index checksum_of(const StateTable& table) {
  Checksum sum;
  for (const auto& [name, array] : table) {
    sum.add(name.data(), name.size());
    std::visit([&](const auto& values) { sum.add(values.data(), values.size() * sizeof(values[0])); }, array);
  }
  return sum.value();
}

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
  content.attributes = {{"/", k_version_name, k_version}, {"/", k_checksum_name, checksum_of(table)}};
  write_hdf5(path, content);
}

StateTable read_state(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) throw InputError("there is no state \"{}\"", path.string());
  std::map<std::string, Index> attributes;
  StateTable table = read_hdf5(path, attributes);
  if (attributes.count(k_version_name) == 0) throw InputError("\"{}\" is no state of matpoint", path.string());
  if (attributes[k_version_name] != k_version) {
    throw InputError("\"{}\" is of version {} of the format of states, and this program reads version {}", path.string(),
                     attributes[k_version_name], k_version);
  }
  if (attributes.count(k_checksum_name) == 0 || attributes[k_checksum_name] != checksum_of(table))
    throw InputError("\"{}\" is damaged: its numbers do not have the checksum that they were written with", path.string());
  return table;
}

}  // namespace matpoint
