// The particles of one body. Their order in memory is private to body/ and transfer/: everybody else sees fields in the order of ids.
#pragma once

#include <vector>

#include "transfer/views.hpp"

namespace matpoint {

template <int Dim>
class Particles {
 public:
  using Array = std::vector<Real>;

  Array x[Dim];                      ///< Position [m].
  Array v[Dim];                      ///< Velocity [m/s].
  Array F[Dim * Dim];                ///< Deformation gradient [1], row by row.
  Array tau[k_stress_size<Dim>];     ///< Kirchhoff stress J sigma [Pa]: xx yy zz xy (yz xz).
  Array mass;                        ///< [kg]
  Array volume0;                     ///< Reference volume [m^3].
  std::vector<Array> history;        ///< Scalars of the law's history.
  std::vector<std::int64_t> id;      ///< Constant through the run; ascending in fields that are handed out.
  Array displacement[Dim];           ///< Scratch between the passes of MUSL [m].

  Index count() const { return static_cast<Index>(mass.size()); }

  /// n particles at rest, undeformed, with ids 0..n-1; positions, masses and volumes are the caller's to fill.
  void resize(Index n, Index history_size);
  ParticleView<Dim> view();

  /// det F of the particle in slot p.
  Real J(Index p) const;

  /// Brings all arrays into the order order[0], order[1], ...; shorter than count() drops the rest.
  void permute(const std::vector<std::uint32_t>& order);

  /// Slots in the order of ascending ids.
  std::vector<std::uint32_t> slots_by_id() const;

  Index memory() const;

 private:
  template <class F>
  void for_each_array(F&& f);
};

}  // namespace matpoint
