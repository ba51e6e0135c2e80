// Temporal VTKHDF files: all times in one file, read by ParaView >= 5.12, VTK >= 9.3 and PyVista.
// Source: VTK File Formats, "VTKHDF File Format", version 2.0 (Kitware).
#pragma once

#include "io/field_file.hpp"

namespace matpoint {

/// The particles of one body, as an unstructured grid of vertices; or a body of finite elements with its cells.
class VtkHdfBody {
 public:
  /// `real`: how real numbers are stored; `compression`: gzip level of the fields, 0 for none. The file is made by the first write.
  VtkHdfBody(std::filesystem::path path, Number real, int compression = 0)
      : path_(std::move(path)), real_(real), compression_(compression) {}

  /// Appends one time. The number of particles may change from call to call, the fields may not. Throws SolverError, and what was
  /// written before stays readable.
  void write(const FieldSet& particles);

 private:
  void create(const FieldSet& first);

  std::filesystem::path path_;
  Number real_;
  int compression_;
  std::vector<Hdf5Dataset> datasets_;
  Index step_count_ = 0;
  Index point_count_ = 0;  ///< Points of all times so far.
  // A part is a topology; times with the same number of points share it.
  Index part_count_ = 0;
  Index part_size_ = -1;
  Index cell_begin_ = 0;          ///< Of the present part,
  Index connectivity_begin_ = 0;  ///< and its first entry of Connectivity.
  Index cells_ = 0;               ///< Of all parts so far.
  Index connectivity_ = 0;
};

/// The nodes of the grid, as an image.
class VtkHdfImage {
 public:
  VtkHdfImage(std::filesystem::path path, Number real, const GridGeometry& grid, int dim, int compression = 0)
      : path_(std::move(path)), real_(real), compression_(compression), grid_(grid), dim_(dim) {}

  /// Appends one time. Throws SolverError, and what was written before stays readable.
  void write(const FieldSet& nodes);

 private:
  void create(const FieldSet& first);

  std::filesystem::path path_;
  Number real_;
  int compression_;
  GridGeometry grid_;
  int dim_;
  std::vector<Hdf5Dataset> datasets_;
  Index step_count_ = 0;
};

}  // namespace matpoint
