// What the writers of field files share: how a field is stored, and what they are asked to write.
#pragma once

#include "core/types.hpp"
#include "io/hdf5_file.hpp"
#include "solver/report.hpp"

namespace matpoint {

/// The particles of one body at one time, in the order of ids; or the nodes of a body of finite elements; or those of the grid (no
/// position: the grid gives it).
struct FieldSet {
  Real time = 0;                     ///< [s]
  std::vector<Real> position;        ///< [m], shape (n, 3).
  std::vector<Field> fields;         ///< Vectors have 3 components.
  const BodyCells* cells = nullptr;  ///< Null: each point is a vertex. The same at all times; lives as long as its solver.
};

/// Connectivity of an unstructured grid; with no cells given, a vertex at each of `points` points.
BodyCells cells_or_vertices(const BodyCells* cells, Index points);

/// ParaView reads vectors with 3 components: a 2D vector gets a zero.
Field pad_vector(Field field);

/// Ids and body numbers are stored as integers, everything else as `real`.
Number stored_number(const std::string& field, Number real);

}  // namespace matpoint
