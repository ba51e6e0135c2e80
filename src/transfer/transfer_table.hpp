// The kernels of one shape function, looked up once at set-up: the only place where names of shapes meet templates.
#pragma once

#include <string>

#include "transfer/g2p.hpp"
#include "transfer/p2g.hpp"

namespace matpoint {

template <int Dim>
struct TransferTable {
  using P2GKernel = void (*)(const GridView<Dim>&, const ParticleView<Dim>&, const std::uint32_t*, Index, Index);
  using G2PKernel = void (*)(const GridView<Dim>&, const ParticleView<Dim>&, Index, Index, Real, Real, Real*, GatherReport&);

  P2GKernel p2g_momentum;
  P2GKernel p2g_momentum_and_force;
  G2PKernel g2p_all;
  G2PKernel g2p_velocity_displacement;
  G2PKernel g2p_gradient_move;
  G2PKernel g2p_gradient;
  G2PKernel g2p_velocity_move;

  G2PKernel g2p(Gather what) const;
};

template <int Dim>
const TransferTable<Dim>& transfer_table_linear();

}  // namespace matpoint
