#include "io/field_file.hpp"

#include <numeric>

namespace matpoint {

Field pad_vector(Field field) {
  if (field.components != 2) return field;
  std::vector<Real> padded;
  padded.reserve(field.values.size() / 2 * 3);
  for (std::size_t i = 0; i + 1 < field.values.size(); i += 2) padded.insert(padded.end(), {field.values[i], field.values[i + 1], 0});
  field.components = 3;
  field.values = std::move(padded);
  return field;
}

BodyCells cells_or_vertices(const BodyCells* cells, Index points) {
  if (cells != nullptr) return *cells;
  BodyCells vertices;
  vertices.nodes.resize(static_cast<std::size_t>(points));
  std::iota(vertices.nodes.begin(), vertices.nodes.end(), 0);
  return vertices;
}

Number stored_number(const std::string& field, Number real) { return field == "id" || field == "body" ? Number::int64 : real; }

}  // namespace matpoint
