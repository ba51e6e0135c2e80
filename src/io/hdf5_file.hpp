// The few things that results need of HDF5: a file whose data sets grow by rows. The only files that know HDF5 are this and its .cpp.
//
// A file is open only while something is appended, so a run that is killed leaves a closed file behind, and a file can be looked at
// while the run goes on. Killed within an append, the file loses that append (in one of 400 trials also the time before it).
// HDF5 does not survive a full disk: it may leave the file half written, or fail again at exit. Therefore an append first reserves
// more room than it can need, and fails before HDF5 has touched anything.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/types.hpp"

namespace matpoint {

/// How numbers are stored in a file.
enum class Number { float32, float64, int64, uint8 };
Index byte_size(Number number);

/// A data set that grows along its first dimension; groups on the way to it are made with it.
struct Hdf5Dataset {
  std::string name;  ///< With its groups: "VTKHDF/PointData/velocity".
  Number number = Number::float64;
  std::vector<Index> row_shape;    ///< Shape of one row; empty for a list of numbers.
  std::vector<Index> chunk_shape;  ///< Of rows and of each dimension of a row.
  int compression = 0;             ///< gzip level, 0 for none.
};

struct Hdf5Attribute {
  std::string group;
  std::string name;
  std::variant<Index, std::vector<Index>, std::vector<Real>, std::string> value;
};

/// Rows to append to a data set, converted to its type of number. Views: the caller keeps the values.
struct Hdf5Rows {
  const Hdf5Dataset* dataset = nullptr;
  std::variant<std::span<const Index>, std::span<const Real>> values;
};

/// Writes a file with empty data sets and the attributes. Throws SolverError; then there is no file.
void create_hdf5(const std::filesystem::path& path, const std::vector<Hdf5Dataset>& datasets, const std::vector<Hdf5Attribute>& attributes);

/// Appends the rows, and only then sets the attribute that tells readers of them. Throws SolverError; when the disk is full the file
/// is as it was.
void append_hdf5(const std::filesystem::path& path, const std::vector<Hdf5Rows>& rows, const Hdf5Attribute& announcement);

}  // namespace matpoint
