#pragma once

namespace matpoint {

const char* version();  ///< "0.1.0"
const char* commit();   ///< `git describe` of the tree that was configured, or "unknown".

}  // namespace matpoint
