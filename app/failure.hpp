#pragma once
/// Failures that only the program knows; main translates them, like the library's, to exit codes.

#include "balance/motion/motion.hpp"

#include <stdexcept>
#include <string>
#include <utility>

namespace balance::app {

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
