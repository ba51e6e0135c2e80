#include <gmock/gmock.h>
#include <gtest/gtest.h>
#if __has_include(<hdf5.h>)
#include <hdf5.h>
#else
#include <hdf5/serial/hdf5.h>
#endif

#include <cmath>
#include <cstring>

#include "core/error.hpp"
#include "io/vtkhdf.hpp"
#include "io/vtu.hpp"
#include "support/temporary_folder.hpp"

namespace matpoint {
namespace {

using test::FileSizeLimit;
using test::message_of;
using test::read_text;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;

/// Reads a whole data set or attribute as doubles; `shape` is set to its extents.
std::vector<Real> read_hdf5(const std::filesystem::path& path, const std::string& name, std::vector<hsize_t>* shape = nullptr) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
  const hid_t space = H5Dget_space(dataset);
  std::vector<hsize_t> extent(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
  H5Sget_simple_extent_dims(space, extent.data(), nullptr);
  if (shape != nullptr) *shape = extent;
  std::vector<Real> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  EXPECT_GE(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0) << name;
  H5Sclose(space);
  H5Dclose(dataset);
  H5Fclose(file);
  return values;
}

Index read_step_count(const std::filesystem::path& path) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t attribute = H5Aopen_by_name(file, "VTKHDF/Steps", "NSteps", H5P_DEFAULT, H5P_DEFAULT);
  Index count = -1;
  H5Aread(attribute, H5T_NATIVE_INT64, &count);
  H5Aclose(attribute);
  H5Fclose(file);
  return count;
}

/// n particles at (i, t, 0) with id i and one vector field.
FieldSet make_particles(Index n, Real time) {
  FieldSet set{time, {}, {{"id", "1", 1, {}}, {"velocity", "m/s", 3, {}}}};
  for (Index i = 0; i < n; ++i) {
    const auto x = static_cast<Real>(i);
    set.position.insert(set.position.end(), {x, time, 0});
    set.fields[0].values.push_back(x);
    set.fields[1].values.insert(set.fields[1].values.end(), {10 * x, 100 * time, 0.1});
  }
  return set;
}

TEST(VtkHdf, times_stand_one_after_the_other_with_their_offsets) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "vtkhdf");
  const auto path = folder.path() / "body.vtkhdf";
  VtkHdfSeries file(folder.path(), "body", Number::float64);
  file.write(make_particles(3, 0));
  file.write(make_particles(3, 0.5));
  EXPECT_EQ(read_step_count(path), 2);
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Steps/Values"), ElementsAre(0, 0.5));
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Steps/PointOffsets"), ElementsAre(0, 3));
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Steps/PointDataOffsets/velocity"), ElementsAre(0, 3));
  std::vector<hsize_t> shape;
  const auto velocity = read_hdf5(path, "VTKHDF/PointData/velocity", &shape);
  EXPECT_THAT(shape, ElementsAre(6, 3));
  EXPECT_EQ(velocity[3 * 5 + 0], 20);
  EXPECT_EQ(velocity[3 * 5 + 1], 50);
  EXPECT_EQ(velocity[3 * 5 + 2], 0.1);
}

TEST(VtkHdf, topology_is_shared_until_the_number_of_particles_changes) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "vtkhdf");
  const auto path = folder.path() / "body.vtkhdf";
  VtkHdfSeries file(folder.path(), "body", Number::float32);
  const std::vector<Index> counts = {3, 3, 2, 2, 0, 1};
  for (std::size_t k = 0; k < counts.size(); ++k) file.write(make_particles(counts[k], static_cast<Real>(k)));
  EXPECT_THAT(read_hdf5(path, "VTKHDF/NumberOfPoints"), ElementsAre(3, 2, 0, 1));
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Steps/PartOffsets"), ElementsAre(0, 0, 1, 1, 2, 3));
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Steps/CellOffsets"), ElementsAre(0, 0, 3, 3, 5, 5));
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Steps/PointOffsets"), ElementsAre(0, 3, 6, 8, 10, 10));
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Connectivity"), ElementsAre(0, 1, 2, 0, 1, 0));
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Offsets"), ElementsAre(0, 1, 2, 3, 0, 1, 2, 0, 0, 1));  // n + 1 per part
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Types"), ElementsAre(1, 1, 1, 1, 1, 1));
}

TEST(VtkHdf, single_precision_rounds_reals_and_keeps_ids) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "vtkhdf");
  VtkHdfSeries file(folder.path(), "body", Number::float32);
  FieldSet set = make_particles(1, 0.1);
  set.fields[0].values[0] = 16777217;  // 2^24 + 1 is no float
  file.write(set);
  EXPECT_EQ(read_hdf5(folder.path() / "body.vtkhdf", "VTKHDF/PointData/velocity")[2], static_cast<float>(0.1));
  EXPECT_EQ(read_hdf5(folder.path() / "body.vtkhdf", "VTKHDF/PointData/id")[0], 16777217);
  EXPECT_EQ(read_hdf5(folder.path() / "body.vtkhdf", "VTKHDF/Steps/Values")[0], 0.1);
}

TEST(VtkHdf, full_disk_leaves_the_times_before_readable) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "vtkhdf");
  const auto path = folder.path() / "body.vtkhdf";
  VtkHdfSeries file(folder.path(), "body", Number::float64);
  constexpr Index k_count = 20000;
  file.write(make_particles(k_count, 0));
  file.write(make_particles(k_count, 1));
  const std::string before = read_text(path);
  // Wherever the disk ends, to just short of what 20000 particles with 7 numbers of 8 bytes need.
  for (const std::uintmax_t room : {0, 1, 4096, 100000, 500000, 1000000}) {
    const FileSizeLimit limit(room);
    EXPECT_THAT(message_of<SolverError>([&] { file.write(make_particles(k_count, 2)); }), HasSubstr("body_000002.h5\": File too large"));
    EXPECT_TRUE(read_text(path) == before) << "with room for " << room << " bytes";
  }
  EXPECT_EQ(read_step_count(path), 2);
  file.write(make_particles(k_count, 3));
  EXPECT_EQ(read_step_count(path), 3);
  const auto position = read_hdf5(path, "VTKHDF/Points");
  ASSERT_EQ(position.size(), 3u * 3 * k_count);
  EXPECT_EQ(position[3 * k_count * 1 + 1], 1);
  EXPECT_EQ(position[3 * k_count * 2 + 1], 3);
}

TEST(VtkHdf, many_times_of_a_small_body_stay_small_and_readable) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "vtkhdf");
  const auto path = folder.path() / "body.vtkhdf";
  VtkHdfSeries file(folder.path(), "body", Number::float32);
  for (int k = 0; k < 600; ++k) file.write(make_particles(5, k));
  const auto times = read_hdf5(path, "VTKHDF/Steps/Values");
  ASSERT_EQ(times.size(), 600u);
  EXPECT_EQ(times[599], 599);
  EXPECT_EQ(read_hdf5(path, "VTKHDF/Points")[3 * 5 * 599 + 1], 599);
  // Per time and field a view has about a hundred bytes.
  EXPECT_LT(std::filesystem::file_size(path), 600000u);
}

TEST(VtkHdf, a_file_that_is_taken_away_leaves_nothing_that_could_be_taken_for_a_result) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "vtkhdf");
  VtkHdfSeries file(folder.path(), "body", Number::float64);
  for (int k = 0; k < 3; ++k) file.write(make_particles(2, k));
  std::filesystem::remove(folder.path() / "vtkhdf" / "body_000001.h5");
  const auto position = read_hdf5(folder.path() / "body.vtkhdf", "VTKHDF/Points");
  EXPECT_TRUE(std::isnan(position[6]));
  EXPECT_EQ(position[0 + 1], 0);
  EXPECT_EQ(position[12 + 1], 2);
}

TEST(VtkHdf, goes_on_from_a_state_and_takes_later_times_back) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "vtkhdf");
  const auto path = folder.path() / "body.vtkhdf";
  StateTable table;
  {
    VtkHdfSeries file(folder.path(), "body", Number::float64);
    for (int k = 0; k < 2; ++k) file.write(make_particles(2 + k, k));
    State state = State::saving(table);
    file.declare_state(state);
    for (int k = 2; k < 5; ++k) file.write(make_particles(7, k));
  }
  VtkHdfSeries file(folder.path(), "body", Number::float64);
  State state = State::loading(table);
  file.declare_state(state);
  file.take_back();
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Steps/Values"), ElementsAre(0, 1));
  file.write(make_particles(3, 9));
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Steps/Values"), ElementsAre(0, 1, 9));
  EXPECT_THAT(read_hdf5(path, "VTKHDF/Steps/PartOffsets"), ElementsAre(0, 1, 1));
  EXPECT_EQ(read_hdf5(path, "VTKHDF/Points").size(), 3u * 8);
}

TEST(VtkHdf, compression_keeps_every_bit_and_saves_room) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "vtkhdf");
  const auto plain_path = folder.path() / "plain.vtkhdf";
  const auto small_path = folder.path() / "small.vtkhdf";
  VtkHdfSeries plain(folder.path(), "plain", Number::float64);
  VtkHdfSeries small(folder.path(), "small", Number::float64, 4);
  for (int k = 0; k < 5; ++k) {
    plain.write(make_particles(1000, k));
    small.write(make_particles(1000, k));
  }
  for (const char* name : {"VTKHDF/Points", "VTKHDF/PointData/velocity", "VTKHDF/PointData/id"}) {
    EXPECT_EQ(read_hdf5(small_path, name), read_hdf5(plain_path, name)) << name;
  }
  // The test's numbers are regular: a third is little to ask.
  const auto size_of = [&](const char* name) { return std::filesystem::file_size(folder.path() / "vtkhdf" / name); };
  EXPECT_LT(3 * size_of("small_000004.h5"), size_of("plain_000004.h5"));
}

TEST(VtkHdf, folder_that_is_gone_is_a_solver_error) {
  const TemporaryFolder folder;
  VtkHdfSeries file(folder.path(), "body", Number::float32);
  EXPECT_THAT(message_of<SolverError>([&] { file.write(make_particles(2, 1)); }),
              HasSubstr("body_000000.h5.tmp\": No such file or directory"));
}

TEST(VtkHdf, grid_image_has_rank_of_the_problem) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "vtkhdf");
  for (const int dim : {2, 3}) {
    const GridGeometry grid{{0, 0, 0}, {0.5, 0.5, dim == 3 ? 0.5 : 0}, {4, 3, dim == 3 ? 2 : 1}};
    const std::size_t nodes = dim == 3 ? 24 : 12;
    const auto path = folder.path() / fmt::format("grid{}.vtkhdf", dim);
    VtkHdfSeries file(folder.path(), fmt::format("grid{}", dim), Number::float64, 0, grid, dim);
    for (const Real time : {0.0, 1.0}) {
      FieldSet set{time, {}, {{"mass", "kg", 1, std::vector<Real>(nodes, time)}, {"velocity", "m/s", 3, std::vector<Real>(3 * nodes, 7)}}};
      set.fields[0].values[5] = 42;  // node (1, 1, 0)
      file.write(set);
    }
    std::vector<hsize_t> shape;
    const auto mass = read_hdf5(path, "VTKHDF/PointData/mass", &shape);
    if (dim == 2)
      EXPECT_THAT(shape, ElementsAre(2, 3, 4));
    else
      EXPECT_THAT(shape, ElementsAre(2, 2, 3, 4));
    EXPECT_EQ(mass[nodes + 5], 42);
    EXPECT_EQ(mass[nodes + 6], 1);
    EXPECT_EQ(read_hdf5(path, "VTKHDF/PointData/velocity").size(), 2 * 3 * nodes);
    EXPECT_THAT(read_hdf5(path, "VTKHDF/Steps/PointDataOffsets/mass"), ElementsAre(0, 1));
  }
}

/// The raw values behind the array `name` of a .vtu or .vti text.
template <class T>
std::vector<T> raw_values(const std::string& text, const std::string& name) {
  const std::size_t element = text.find("Name=\"" + name + "\"");
  EXPECT_NE(element, std::string::npos) << name;
  const std::size_t offset = std::stoul(text.substr(text.find("offset=\"", element) + 8));
  const char* raw = text.data() + text.find("<AppendedData encoding=\"raw\">\n_") + 31 + offset;
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, raw, 8);
  std::vector<T> values(bytes / sizeof(T));
  std::memcpy(values.data(), raw + 8, bytes);
  return values;
}

TEST(Vtu, arrays_are_found_at_their_offsets) {
  const std::string text = vtu_text(make_particles(3, 0.25), Number::float64);
  EXPECT_THAT(text, HasSubstr("<Piece NumberOfPoints=\"3\" NumberOfCells=\"3\">"));
  EXPECT_THAT(text, HasSubstr("Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">0.25<"));
  EXPECT_THAT(raw_values<double>(text, "Points"), ElementsAre(0, 0.25, 0, 1, 0.25, 0, 2, 0.25, 0));
  EXPECT_THAT(raw_values<std::int64_t>(text, "connectivity"), ElementsAre(0, 1, 2));
  EXPECT_THAT(raw_values<std::int64_t>(text, "offsets"), ElementsAre(1, 2, 3));
  EXPECT_THAT(raw_values<std::uint8_t>(text, "types"), ElementsAre(1, 1, 1));
  EXPECT_THAT(raw_values<std::int64_t>(text, "id"), ElementsAre(0, 1, 2));
  EXPECT_THAT(raw_values<float>(vtu_text(make_particles(1, 0), Number::float32), "velocity"), ElementsAre(0.f, 0.f, 0.1f));
}

TEST(Vtu, grid_is_an_image_with_the_extent_of_the_nodes) {
  const GridGeometry grid{{-1, 2, 0}, {0.5, 0.25, 0}, {4, 3, 1}};
  const FieldSet set{0, {}, {{"mass", "kg", 1, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}}}};
  const std::string text = vti_text(set, grid, Number::float32);
  EXPECT_THAT(text, HasSubstr("<ImageData WholeExtent=\"0 3 0 2 0 0\" Origin=\"-1 2 0\" Spacing=\"0.5 0.25 1\">"));
  EXPECT_EQ(raw_values<float>(text, "mass")[11], 11.f);
}

TEST(Vtu, series_lists_every_complete_file) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "vtu");
  VtuSeries series(folder.path(), "a&b", Number::float32);
  series.write(make_particles(2, 0));
  series.write(make_particles(2, 0.5));
  const std::string list = read_text(folder.path() / "a&b.pvd");
  EXPECT_THAT(list, HasSubstr("<DataSet timestep=\"0\" part=\"0\" file=\"vtu/a&amp;b_000000.vtu\"/>\n"
                              "<DataSet timestep=\"0.5\" part=\"0\" file=\"vtu/a&amp;b_000001.vtu\"/>\n</Collection>"));
  {
    const FileSizeLimit limit(500);
    EXPECT_THAT(message_of<SolverError>([&] { series.write(make_particles(200, 1)); }), HasSubstr("a&b_000002.vtu\": File too large"));
  }
  EXPECT_EQ(read_text(folder.path() / "a&b.pvd"), list);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "vtu" / "a&b_000002.vtu"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "vtu" / "a&b_000002.vtu.tmp"));
}

TEST(Fields, two_components_become_a_vector_and_other_fields_stay) {
  EXPECT_THAT(pad_vector({"velocity", "m/s", 2, {1, 2, 3, 4}}).values, ElementsAre(1, 2, 0, 3, 4, 0));
  EXPECT_EQ(pad_vector({"velocity", "m/s", 2, {}}).components, 3);
  EXPECT_EQ(pad_vector({"stress", "Pa", 6, std::vector<Real>(6)}).components, 6);
}

}  // namespace
}  // namespace matpoint
