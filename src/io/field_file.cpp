#include "io/field_file.hpp"

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

Number stored_number(const std::string& field, Number real) { return field == "id" || field == "body" ? Number::int64 : real; }

}  // namespace matpoint
