#include "transfer/transfer_table.hpp"

#include "shape/linear.hpp"

namespace matpoint {
namespace {

template <int Dim, class Shape>
const TransferTable<Dim>& table_of() {
  static const TransferTable<Dim> table{
      &P2G<Dim, Shape, Map::momentum>::run,           &P2G<Dim, Shape, Map::momentum_and_force>::run,
      &G2P<Dim, Shape, Gather::all>::run,             &G2P<Dim, Shape, Gather::velocity_displacement>::run,
      &G2P<Dim, Shape, Gather::gradient_move>::run,   &G2P<Dim, Shape, Gather::gradient>::run,
      &G2P<Dim, Shape, Gather::velocity_move>::run,
  };
  return table;
}

}  // namespace

template <int Dim>
typename TransferTable<Dim>::G2PKernel TransferTable<Dim>::g2p(Gather what) const {
  switch (what) {
    case Gather::all: return g2p_all;
    case Gather::velocity_displacement: return g2p_velocity_displacement;
    case Gather::gradient_move: return g2p_gradient_move;
    case Gather::gradient: return g2p_gradient;
    case Gather::velocity_move: return g2p_velocity_move;
  }
  return nullptr;
}

template <int Dim>
const TransferTable<Dim>& transfer_table_linear() {
  return table_of<Dim, ShapeLinear>();
}

template struct TransferTable<2>;
template struct TransferTable<3>;
template const TransferTable<2>& transfer_table_linear<2>();
template const TransferTable<3>& transfer_table_linear<3>();

}  // namespace matpoint
