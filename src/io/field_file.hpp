// What the writers of field files share: how a field is stored, and what they are asked to write.
#pragma once

#include "core/types.hpp"
#include "io/hdf5_file.hpp"
#include "solver/solver.hpp"

namespace matpoint {

/// The particles of one body at one time, in the order of ids; or the nodes of the grid (no position: the grid gives it).
struct FieldSet {
  Real time = 0;               ///< [s]
  std::vector<Real> position;  ///< [m], shape (n, 3).
  std::vector<Field> fields;   ///< Vectors have 3 components.
};

/// ParaView reads vectors with 3 components: a 2D vector gets a zero.
Field pad_vector(Field field);

/// Ids and body numbers are stored as integers, everything else as `real`.
Number stored_number(const std::string& field, Number real);

}  // namespace matpoint
