#pragma once
/// Failures that only the program knows; main translates them, like the library's, to exit codes.

#include "balance/motion/motion.hpp"

#include <stdexcept>

namespace balance::app {

/// Options or arguments that make no sense.
class UsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A call that cannot even be taken apart: the user needs to see the usage.
class CallError : public UsageError {
  using UsageError::UsageError;
};

/// The mechanism cannot do what was asked.
class MotionFailure : public std::runtime_error {
 public:
  explicit MotionFailure(const MotionOutcome& result) : std::runtime_error(result.reason), outcome(result) {}
  MotionOutcome outcome;
};

}  // namespace balance::app
