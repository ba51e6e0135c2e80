// Which shape functions there are: what a case names, and how far they reach.
#pragma once

namespace matpoint {

/// Shape functions of the background.
enum class ShapeKind { linear, bspline2, bspline3, gimp, cpdi };

/// Nodes of a cell in each direction, beyond the first.
constexpr int span_of(ShapeKind shape) { return shape == ShapeKind::linear ? 1 : shape == ShapeKind::bspline2 ? 2 : 3; }
constexpr int k_span_max = 3;

/// Whether particles have domains that reach into the next cells, where nodes stay the corners of cells: there is one before the first
/// cell and one after the last.
constexpr bool has_domains(ShapeKind shape) { return shape == ShapeKind::gimp || shape == ShapeKind::cpdi; }

}  // namespace matpoint
