// A body of particles with one material.
#pragma once

#include "body/body.hpp"
#include "body/particles.hpp"
#include "material/material.hpp"
#include "transfer/transfer_table.hpp"

namespace matpoint {

template <int Dim>
class ParticleBody final : public Body<Dim> {
 public:
  /// Fills the body's region. Throws InputError for an empty body and for particles outside the grid.
  ParticleBody(const BodySpec& spec, const Grid<Dim>& grid, const TransferTable<Dim>& transfer);

  const std::string& name() const override { return name_; }
  Index particle_count() const override { return particles_.count(); }
  void locate(const Grid<Dim>& grid, std::vector<char>& is_band_occupied) override;
  void p2g(Grid<Dim>& grid, Map what) override;
  void g2p(const Grid<Dim>& grid, Gather what, Real dt, Real flip) override;
  Real viscous_dissipation() const override { return viscous_dissipation_; }
  BadPoint bad_point() const override;
  bool has_escapes() const override { return has_escapes_; }
  void append_escapes(const Grid<Dim>& grid, std::size_t body, std::vector<Escape>& escapes) const override;
  void remove_escaped(const Grid<Dim>& grid, const Vec3& gravity, Ledger& ledger) override;
  Real stable_dt(const Grid<Dim>& grid) const override;
  Real mass() const override { return mass_; }
  Real smallest_particle_mass() const override;
  BodyTotals totals(const Vec3& gravity) const override;
  std::vector<std::string> field_names() const override;
  Field field(const std::string& name, std::size_t body) const override;
  Index memory() const override;

 private:
  /// What one chunk of particles reports after a pass; summed in the order of the chunks.
  struct ChunkReport {
    GatherReport gather;
    Real dissipated = 0;
    Index first_inverted = -1;
  };

  bool is_outside(const Grid<Dim>& grid, Index p) const;
  void sort_by_cell(const Grid<Dim>& grid);
  void order_by_band(const Grid<Dim>& grid);
  Vec3 position(Index p) const;
  BodyTotals totals_of(Index begin, Index end, const Vec3& gravity) const;
  std::array<Real, 6> cauchy_stress(Index p) const;
  std::array<Real, 9> deformation_gradient(Index p) const;

  std::string name_;
  std::shared_ptr<Material> material_;
  const TransferTable<Dim>& transfer_;
  Particles<Dim> particles_;

  // Particles in the order of bands, stable in memory order: the order of sums depends on the grid and never on threads.
  std::vector<std::uint32_t> band_order_;
  std::vector<Index> band_begin_;
  bool is_band_order_valid_ = false;
  Index moved_since_sort_ = 0;
  bool is_sorted_ = false;

  std::vector<ChunkReport> reports_;
  Real mass_ = 0;
  Real viscous_dissipation_ = 0;
  Index bad_slot_ = -1;
  bool has_escapes_ = false;
};

/// All fields that a body of particles has.
const std::vector<std::string>& particle_field_names();

}  // namespace matpoint
