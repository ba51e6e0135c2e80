#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "io/fake_solver.hpp"
#include "io/probe.hpp"
#include "support/temporary_folder.hpp"

namespace matpoint {
namespace {

using test::FakeSolver;
using test::message_of;
using test::read_text;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;

std::map<std::string, Real> named_row(const Snapshot& snapshot) {
  const std::vector<HistoryColumn> columns = history_columns(snapshot.solver);
  const std::vector<Real> row = history_row(snapshot);
  EXPECT_EQ(columns.size(), row.size());
  std::map<std::string, Real> named;
  for (std::size_t i = 0; i < row.size(); ++i) named[columns[i].name] = row[i];
  EXPECT_EQ(named.size(), row.size()) << "two columns have one name";
  return named;
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> all;
  std::stringstream stream(text);
  for (std::string line; std::getline(stream, line);) all.push_back(line);
  return all;
}

TEST(History, totals_are_sums_and_extremes_of_the_bodies) {
  const Case problem;
  const FakeSolver solver;
  auto row = named_row({problem, solver});
  EXPECT_EQ(row["particle_count"], 9);
  EXPECT_EQ(row["mass"], 18);  // 2 kg for each of 9 particles
  EXPECT_EQ(row["left.mass"], 12);
  EXPECT_EQ(row["momentum_x"], 6);         // 12 * 1 - 6 * 1
  EXPECT_EQ(row["momentum_y"], 6);         // 12 * 0.5
  EXPECT_EQ(row["kinetic_energy"], 10.5);  // 12 (1 + 0.25)/2 + 6/2
  EXPECT_EQ(row["von_mises_max"], 200);
  EXPECT_EQ(row["left.von_mises_max"], 100);
  EXPECT_EQ(row["J_min"], 0.8);
  EXPECT_EQ(row["J_max"], 1.1 + 0.1);
  EXPECT_EQ(row["lower_x"], 0);
  EXPECT_EQ(row["upper_x"], 0.5);
  EXPECT_EQ(row["upper_y"], 1);
  // (12 * 0.25 + 6 * 0.1) / 18, with a few roundings of numbers of order 1
  EXPECT_NEAR(row["center_of_mass_x"], 0.2, 10 * std::numeric_limits<Real>::epsilon());
  EXPECT_EQ(row.count("momentum_z"), 0u);
  const FakeSolver solid(3);
  EXPECT_EQ(named_row({problem, solid}).count("momentum_z"), 1u);
}

TEST(History, transfer_loss_closes_the_energy_balance) {
  const Case problem;
  FakeSolver solver;
  solver.books.damping_dissipation = 1;
  solver.books.viscous_dissipation = 2;
  solver.books.boundary_work = 0.5;
  solver.books.removed_energy = 4;
  Snapshot now(problem, solver);
  now.initial_energy = 20;
  auto row = named_row(now);
  // Present: 10.5 kinetic + 0.5 strain - 0.25 gravitational = 10.75; 20 + 0.5 put in - 1 - 2 - 4 taken out = 13.5 should be there.
  EXPECT_EQ(row["transfer_loss"], 2.75);
}

TEST(History, body_without_particles_has_no_place_and_does_not_spoil_the_totals) {
  const Case problem;
  FakeSolver solver;
  solver.bodies[1].ids.clear();
  auto row = named_row({problem, solver});
  EXPECT_TRUE(std::isnan(row["right.center_of_mass_x"]));
  EXPECT_TRUE(std::isnan(row["right.J_min"]));
  EXPECT_EQ(row["right.mass"], 0);
  EXPECT_EQ(row["center_of_mass_x"], 0.25);
  EXPECT_EQ(row["J_min"], 0.9);
}

TEST(History, numbers_read_back_to_the_same_bits) {
  const std::vector<Real> values = {1.0 / 3, 1e-300, -2.5e17, 316, 0.1 + 0.2};
  std::stringstream stream(csv_row(values));
  for (const Real value : values) {
    std::string cell;
    std::getline(stream, cell, ',');
    EXPECT_EQ(std::stod(cell), value);
  }
}

TEST(History, file_has_a_header_and_a_row_per_call) {
  const TemporaryFolder folder;
  const Case problem;
  const FakeSolver solver;
  History history(folder.path() / "history.csv", solver);
  Snapshot now(problem, solver);
  history.write(history_row(now));
  now.time = 0.25;
  now.step = 7;
  now.dt = 0.125;
  history.write(history_row(now));
  const auto text = lines(read_text(folder.path() / "history.csv"));
  ASSERT_EQ(text.size(), 3u);
  EXPECT_TRUE(text[0].starts_with("time,step,dt,particle_count,mass,momentum_x,momentum_y,"));
  EXPECT_TRUE(text[1].starts_with("0,0,0,9,18,"));
  EXPECT_TRUE(text[2].starts_with("0.25,7,0.125,9,18,"));
  EXPECT_EQ(std::count(text[0].begin(), text[0].end(), ','), std::count(text[2].begin(), text[2].end(), ','));
}

TEST(Probe, nearest_takes_the_lower_id_when_two_are_as_near) {
  const FakeSolver solver;
  ProbeSpec spec;
  spec.name = "tip";
  spec.body = "left";
  spec.nearest = Vec3{0.52, 3, 0};
  EXPECT_EQ(find_probe(spec, solver).particle, 5);
  FakeSolver twins;
  twins.bodies[0].ids = {3, 3, 4};
  spec.nearest = Vec3{0.3, 0, 0};
  EXPECT_EQ(find_probe(spec, twins).particle, 3);
  spec.body = "right";
  EXPECT_EQ(find_probe(spec, solver).body, 1u);
}

TEST(Probe, unknown_body_and_particle_are_named) {
  const FakeSolver solver;
  ProbeSpec spec;
  spec.name = "tip";
  spec.place = "case.toml:9";
  spec.body = "rigth";
  spec.particle = 3;
  EXPECT_EQ(message_of<InputError>([&] { find_probe(spec, solver); }),
            "case.toml:9: probe \"tip\": body = \"rigth\" is unknown, allowed: \"left\" or \"right\"; did you mean \"right\"?");
  spec.body = "right";
  EXPECT_EQ(message_of<InputError>([&] { find_probe(spec, solver); }),
            "case.toml:9: probe \"tip\": particle = 3 does not exist, body \"right\" has particles 0 to 2");
}

TEST(Probe, follows_its_particle_by_id_until_it_is_removed) {
  const TemporaryFolder folder;
  const Case problem;
  FakeSolver solver;
  Probe probe(folder.path() / "probe.csv", {0, 4}, 2);
  probe.write(probe.row({problem, solver}));
  solver.remove(0, 1);  // now the particle stands in another row
  solver.time = 2;
  probe.write(probe.row({problem, solver}));
  solver.remove(0, 4);
  probe.write(probe.row({problem, solver}));
  EXPECT_THAT(lines(read_text(folder.path() / "probe.csv")),
              ElementsAre("time,position_x,position_y,velocity_x,velocity_y,stress_xx,stress_yy,stress_zz,stress_xy",
                          "0,0.4,0,1,0.5,4.1,4.2,4.3,4.4", "0,2.4,1,1,0.5,4.1,4.2,4.3,4.4", "0,nan,nan,nan,nan,nan,nan,nan,nan"));
}

TEST(Probe, three_dimensions_have_six_stress_components) {
  const TemporaryFolder folder;
  const Case problem;
  const FakeSolver solver(3);
  Probe probe(folder.path() / "probe.csv", {1, 2}, 3);
  probe.write(probe.row({problem, solver}));
  const auto text = lines(read_text(folder.path() / "probe.csv"));
  ASSERT_EQ(text.size(), 2u);
  EXPECT_THAT(text[0], HasSubstr("velocity_z,stress_xx,stress_yy,stress_zz,stress_xy,stress_yz,stress_xz"));
  EXPECT_EQ(text[1], "0,0.2,1,0.02,-1,0,0,2.1,2.2,2.3,2.4,2.5,2.6");
}

}  // namespace
}  // namespace matpoint
