// The few things that results and states need of HDF5: files that are written whole, and read whole. The only files that know HDF5 are this
// and its .cpp.
//
// A file of HDF5 that grows is not safe: a run that is killed while it writes leaves metadata that no reader takes, and so does a full
// disk. Here each file is made in memory and appears complete (write_file) or not at all. What belongs together in time is joined by one
// more file, whose data sets are views of those in the others (HDF5's virtual data sets), and which is replaced as a whole.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/state.hpp"
#include "core/types.hpp"
#include "io/output_file.hpp"

namespace matpoint {

/// How numbers are stored in a file.
enum class Number { float32, float64, int64, uint8 };
Index byte_size(Number number);

/// A data set; groups on the way to it are made with it. A view: the caller keeps the values.
struct Hdf5Array {
  std::string name;  ///< With its groups: "VTKHDF/PointData/velocity".
  Number number = Number::float64;
  std::vector<Index> row_shape;  ///< Shape of one row; empty for a list of numbers.
  std::variant<std::span<const Real>, std::span<const float>, std::span<const Index>, std::string_view> values;
  int compression = 0;  ///< gzip level, 0 for none.
};

/// Rows of a data set in another file.
struct Hdf5Source {
  std::string file;  ///< Beside the file that joins, or below it.
  std::string dataset;
  Index rows = 0;
};

/// A data set that is those of other files, one after the other. Where one is missing, readers see nan or -1.
struct Hdf5Joined {
  std::string name;
  Number number = Number::float64;
  std::vector<Index> row_shape;
  std::vector<Hdf5Source> sources;
  bool is_row = false;  ///< There is one row, and the data set has its shape.
};

struct Hdf5Attribute {
  std::string group;
  std::string name;
  std::variant<Index, std::vector<Index>, std::vector<Real>, std::string> value;
};

struct Hdf5Content {
  std::string title;  ///< Of a sealed file: what it is, one line. Empty: not sealed.
  std::vector<Hdf5Array> arrays;
  std::vector<Hdf5Joined> joined;
  std::vector<Hdf5Attribute> attributes;
};

/// Writes or replaces a file (write_file). Throws SolverError, and then the file is what it was.
void write_hdf5(const std::filesystem::path& path, const Hdf5Content& content, OnDisk what = OnDisk::name);

/// The title of a sealed file, whose first 512 bytes are a text: title, size and checksum of what follows. HDF5 passes over them. Empty for
/// another file. Throws InputError for one that cannot be read.
std::string title_of(const std::filesystem::path& path);

/// All data sets of a sealed file by their names. HDF5 is not shown a file that is not as it was written: damaged metadata make it crash.
/// Throws InputError.
StateTable read_sealed_hdf5(const std::filesystem::path& path);

}  // namespace matpoint
