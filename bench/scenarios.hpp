// The named scenarios of the benchmark.
#pragma once

#include "measure.hpp"

namespace matpoint::bench {

struct ScenarioSet {
  std::string name;
  std::string about;
  std::vector<Scenario> scenarios;
};

/// All sets. `particles`: the size of those that have one, default 1e6.
std::vector<ScenarioSet> scenario_sets(std::size_t particles);

}  // namespace matpoint::bench
