#include "io/vtu.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "io/output_file.hpp"

namespace matpoint {
namespace {

std::string xml_escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c;
  }
  return escaped;
}

const char* vtk_type(Number number) {
  switch (number) {
    case Number::float32: return "Float32";
    case Number::float64: return "Float64";
    case Number::int64: return "Int64";
    case Number::uint8: break;
  }
  return "UInt8";
}

template <class Stored, class T>
void put(std::string& raw, const std::vector<T>& values) {
  const std::size_t begin = raw.size();
  raw.resize(begin + values.size() * sizeof(Stored));
  char* out = raw.data() + begin;
  for (const T value : values) {
    const auto stored = static_cast<Stored>(value);
    std::memcpy(out, &stored, sizeof stored);
    out += sizeof stored;
  }
}

/// The arrays of a file: their XML elements refer to the raw values at its end.
class Arrays {
 public:
  template <class T>
  std::string add(const std::string& name, Number number, int components, const std::vector<T>& values) {
    const std::size_t offset = raw_.size();
    put<std::uint64_t>(raw_, std::vector<std::size_t>{values.size() * static_cast<std::size_t>(byte_size(number))});
    switch (number) {
      case Number::float32: put<float>(raw_, values); break;
      case Number::float64: put<double>(raw_, values); break;
      case Number::int64: put<std::int64_t>(raw_, values); break;
      case Number::uint8: put<std::uint8_t>(raw_, values); break;
    }
    return fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
                       vtk_type(number), xml_escaped(name), components, offset);
  }
  std::string point_data(const FieldSet& set, Number real) {
    std::string text = "<PointData>\n";
    for (const Field& field : set.fields) text += add(field.name, stored_number(field.name, real), field.components, field.values);
    return text + "</PointData>\n";
  }
  std::string file(const std::string& type, const std::string& content) const {
    const char* order = std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";
    return fmt::format(
               "<?xml version=\"1.0\"?>\n<VTKFile type=\"{0}\" version=\"1.0\" byte_order=\"{1}\" header_type=\"UInt64\">\n"
               "{2}<AppendedData encoding=\"raw\">\n_",
               type, order, content) +
           raw_ + "\n</AppendedData>\n</VTKFile>\n";
  }

 private:
  std::string raw_;
};

std::string time_value(Real time) {
  return fmt::format(
      "<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n</FieldData>\n",
      time);
}

}  // namespace

std::string vtu_text(const FieldSet& particles, Number real) {
  const std::size_t n = particles.position.size() / 3;
  const BodyCells cells = cells_or_vertices(particles.cells, static_cast<Index>(n));
  std::vector<Index> ends;
  for (Index end = cells.nodes_per_cell; end <= static_cast<Index>(cells.nodes.size()); end += cells.nodes_per_cell) ends.push_back(end);
  Arrays arrays;
  std::string text = fmt::format("<UnstructuredGrid>\n{}<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n",
                                 time_value(particles.time), n, ends.size());
  text += arrays.add("Points", real, 3, particles.position) + "</Points>\n<Cells>\n";
  text += arrays.add("connectivity", Number::int64, 1, cells.nodes);
  text += arrays.add("offsets", Number::int64, 1, ends);
  text += arrays.add("types", Number::uint8, 1, std::vector<Index>(ends.size(), cells.vtk_type)) + "</Cells>\n";
  text += arrays.point_data(particles, real) + "</Piece>\n</UnstructuredGrid>\n";
  return arrays.file("UnstructuredGrid", text);
}

std::string vti_text(const FieldSet& nodes, const GridGeometry& grid, Number real) {
  const std::string extent = fmt::format("0 {} 0 {} 0 {}", grid.nodes[0] - 1, grid.nodes[1] - 1, grid.nodes[2] - 1);
  const Real height = grid.nodes[2] > 1 ? grid.cell_size[2] : 1;  // VTK refuses a spacing of 0
  Arrays arrays;
  std::string text = fmt::format("<ImageData WholeExtent=\"{0}\" Origin=\"{1}\" Spacing=\"{2} {3} {4}\">\n{5}<Piece Extent=\"{0}\">\n",
                                 extent, fmt::join(grid.lower, " "), grid.cell_size[0], grid.cell_size[1], height, time_value(nodes.time));
  text += arrays.point_data(nodes, real) + "</Piece>\n</ImageData>\n";
  return arrays.file("ImageData", text);
}

std::string VtuSeries::file_of(std::size_t time) const { return fmt::format("vtu/{}_{:06}.{}", name_, time, grid_ ? "vti" : "vtu"); }

void VtuSeries::write_list(const std::vector<Real>& times) const {
  std::string entries;
  for (std::size_t t = 0; t < times.size(); ++t)
    entries += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", times[t], xml_escaped(file_of(t)));
  write_file(
      folder_ / (name_ + ".pvd"),
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n" + entries + "</Collection>\n</VTKFile>\n",
      OnDisk::content);
}

void VtuSeries::write(const FieldSet& set) {
  write_file(folder_ / file_of(times_.size()), grid_ ? vti_text(set, *grid_, real_) : vtu_text(set, real_));
  std::vector<Real> times = times_;
  times.push_back(set.time);
  write_list(times);
  times_ = std::move(times);
}

}  // namespace matpoint
