#include "verify/acceptance.hpp"

#include <sstream>

#include "core/error.hpp"

namespace matpoint {
namespace {

/// Columns: case, quantity, value, tolerance, bound, kind, scheme, dt, t_end, note. Only the note may contain commas.
VerifyRow row_of(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream stream(line);
  for (std::string cell; cells.size() < 9 && std::getline(stream, cell, ',');) cells.push_back(cell);
  std::string note;
  std::getline(stream, note);
  if (cells.size() < 9) throw std::logic_error("verification: too few columns: " + line);
  VerifyRow row;
  row.group = cells[0];
  row.quantity = cells[1];
  row.expected = std::stod(cells[2]);
  row.tolerance = cells[3].empty() ? 0 : std::stod(cells[3]);
  row.bound = cells[4] == "<=" ? Bound::at_most : cells[4] == ">=" ? Bound::at_least : Bound::within;
  row.kind = cells[5] == "accept" ? RowKind::accept : cells[5] == "truth" ? RowKind::truth : RowKind::goal;
  row.source = cells[6] + " dt=" + cells[7] + (note.empty() ? "" : "; " + note);
  return row;
}

}  // namespace

std::vector<VerifyRow> acceptance_rows(const std::string& table) {
  std::vector<VerifyRow> rows;
  std::stringstream stream(acceptance_tables().at(table));
  std::string line;
  std::getline(stream, line);  // header
  while (std::getline(stream, line)) {
    if (!line.empty()) rows.push_back(row_of(line));
  }
  return rows;
}

std::vector<VerifyRow> acceptance_rows() {
  std::vector<VerifyRow> rows;
  for (const char* table : {"explicit_acceptance", "explicit_musl", "explicit_remedies"}) {
    std::vector<VerifyRow> some = acceptance_rows(table);
    std::move(some.begin(), some.end(), std::back_inserter(rows));
  }
  return rows;
}

}  // namespace matpoint
