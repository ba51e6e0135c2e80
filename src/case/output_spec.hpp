// The sections [output] and [[probe]] of a case.
#pragma once

#include <optional>

#include "core/parameters.hpp"

namespace matpoint {

struct OutputSpec {
  std::optional<Real> history_every;
  std::optional<Real> fields_every;
  std::vector<Real> fields_at;
  std::vector<std::string> formats = {"vtkhdf"};
  std::vector<std::string> fields;  ///< Empty: all of the body's fields.
  bool grid = false;
  std::optional<Index> checkpoint_steps;
  std::optional<Real> checkpoint_time;  ///< Simulated [s].
  std::optional<Real> checkpoint_wall;  ///< On the clock on the wall [s].
  std::string precision = "single";
  int compression = 0;  ///< Of VTKHDF files: gzip level, 0 for none.
  static void declare(ParameterTable<OutputSpec>& table);
};

/// A particle whose motion and stress are written over time.
struct ProbeSpec {
  std::string name;
  std::string body;
  std::optional<Index> particle;  ///< Either the id
  std::optional<Vec3> nearest;    ///< or the particle that is nearest to this point at the start [m].
  std::string place;
  static void declare(ParameterTable<ProbeSpec>& table);
};

/// What goes beyond single values. Throws InputError.
void check_output(OutputSpec& output, const Input& input, const ReadContext& context);
void check_probe(ProbeSpec& probe, const Input& input, const ReadContext& context);

}  // namespace matpoint
