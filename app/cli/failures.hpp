#pragma once
/// Failures that only the program knows; main translates them, like the library's, to exit codes.

#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <stdexcept>
#include <string>
#include <utility>

namespace balance::app {

/// How the program ends: part of its interface, listed in every --help.
enum class ExitCode {
  done = 0,
  not_met = 1,    ///< a requirement is not met, or a design is only a compromise
  usage = 2,      ///< wrong options or arguments
  spec = 3,       ///< the spec is invalid
  mechanism = 4,  ///< the mechanism cannot do it: unreachable, singular, not assembled
  system = 5,     ///< a file or the system fails
  signal = 128,   ///< plus the signal's number: 130 after Ctrl-C
};

/// Options or arguments that make no sense.
class UsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A call that cannot even be taken apart: the user needs to see the usage.
class SyntaxUsageError : public UsageError {
 public:
  /// @param its_help the command that shows the usage
  explicit SyntaxUsageError(const std::string& reason, std::string its_help = "balance --help")
      : UsageError(reason), help(std::move(its_help)) {}
  std::string help;
};

/// The mechanism cannot have what was asked: no conditions, no design.
class MechanismFailure : public std::runtime_error {
 public:
  MechanismFailure(std::string its_status, const std::string& reason)
      : std::runtime_error(reason), status(std::move(its_status)) {}
  std::string status;
};

/// The mechanism cannot make a motion that was asked for.
class MotionFailure : public std::runtime_error {
 public:
  explicit MotionFailure(const MotionOutcome& result) : std::runtime_error(result.reason), outcome(result) {}
  MotionOutcome outcome;
};

}  // namespace balance::app
