#pragma once
/// The runs that `balance plot` draws.

#include "balance/read/result_file.hpp"

#include <string>

namespace balance::app {

/// A result file, or a spec (`arm.yaml`, `arm.yaml:trajectory`) that is run now.
/// @throws SystemError for a file that cannot be read, SpecError, UsageError for a trajectory that does not exist, MotionFailure
RunFile read_or_run(const std::string& name);

}  // namespace balance::app
