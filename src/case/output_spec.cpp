#include "case/output_spec.hpp"

#include "case/case_reading.hpp"

namespace matpoint {

void check_output(OutputSpec& output, const Input& input, const ReadContext& context) {
  check_words(output.formats, "formats", {"vtkhdf", "vtu"}, input, context);
  check_words({output.precision}, "precision", {"single", "double"}, input, context);
}

void check_probe(ProbeSpec& probe, const Input& input, const ReadContext& context) {
  if (probe.particle.has_value() != probe.nearest.has_value()) return;
  fail_input(input, context,
             probe.particle ? "particle and nearest are both given; give one of them"
                            : "which particle? Give particle = its id, or nearest = [x, y] of a point");
}

void OutputSpec::declare(ParameterTable<OutputSpec>& table) {
  table.optional("history_every", "s", &OutputSpec::history_every, positive(), "Interval of history.csv and probes; default: 200 rows.");
  table.optional("fields_every", "s", &OutputSpec::fields_every, positive(),
                 "Interval of field files; default: 50 times, none with fields_at.");
  table.optional("fields_at", "s", &OutputSpec::fields_at, non_negative(), "Further times of field files.");
  table.optional("formats", "1", &OutputSpec::formats, any_number(),
                 "Of field files: \"vtkhdf\" (ParaView 5.12 or newer, PyVista), \"vtu\" (older ParaView).");
  table.optional("fields", "1", &OutputSpec::fields, any_number(), "Fields to write; empty for all but those on request (`matpoint list fields`).");
  table.optional("grid", "1", &OutputSpec::grid, any_number(), "Whether the nodes' mass and velocity are written, too.");
  table.optional("checkpoint_steps", "1", &OutputSpec::checkpoint_steps, positive(),
                 "A checkpoint after every so many steps; the last two are kept (`matpoint run --continue`).");
  table.optional("checkpoint_time", "s", &OutputSpec::checkpoint_time, positive(), "The same after so much simulated time.");
  table.optional("checkpoint_wall", "s", &OutputSpec::checkpoint_wall, positive(), "The same after so many seconds of computing.");
  table.optional("precision", "1", &OutputSpec::precision, any_number(), "\"single\" or \"double\", of field files.");
  table.optional("compression", "1", &OutputSpec::compression,
                 Constraint{"an integer from 0 to 9", [](Real x) { return x >= 0 && x <= 9; }},
                 "gzip level of VTKHDF files: 0 for none, 1 fast to 9 small.");
}

void ProbeSpec::declare(ParameterTable<ProbeSpec>& table) {
  table.required("name", "1", &ProbeSpec::name, any_number(), "Names the file probe_<name>.csv.");
  table.required("body", "1", &ProbeSpec::body, any_number(), "The particle's body.");
  table.optional("particle", "1", &ProbeSpec::particle, non_negative(), "The particle's id; either this or nearest.");
  table.optional("nearest", "m", &ProbeSpec::nearest, any_number(), "The particle that is nearest to this point at the start.");
}

}  // namespace matpoint
