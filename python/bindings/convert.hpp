// Between Python objects and what the core takes and gives.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "core/input.hpp"
#include "core/types.hpp"

namespace matpoint::python {

namespace nb = nanobind;

using Array = nb::ndarray<nb::numpy, Real>;
/// A dict of names to anything, as stubs should say it.
using Table = nb::typed<nb::dict, nb::str, nb::any>;
/// What Python functions may return and users may pass: converted to contiguous float64 before it arrives.
using ConstArray = nb::ndarray<nb::numpy, const Real, nb::c_contig, nb::device::cpu>;

/// A tree of dicts, lists, numbers, texts and core objects (regions, layouts, materials, functions). Throws InputError for anything else;
/// `where` names the value in that message.
Input to_input(nb::handle value, const std::string& where, int depth = 0);

/// The tree as dicts and lists.
nb::object from_input(const Input& input);

/// A new NumPy array that owns the values.
Array make_array(std::vector<Real> values, const std::vector<std::size_t>& shape);

/// A field as (n,), (n, dim) or (n, 3, 3); the six components of a symmetric tensor become nine.
Array make_array(Field field);

}  // namespace matpoint::python
