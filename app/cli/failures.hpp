#pragma once
/// Failures specific to the program. Like those of the library, main translates them to exit codes.

#include "balance/foundation/base/error.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/motion/study/study.hpp"

#include <stdexcept>
#include <string>
#include <utility>

namespace balance::app {

/// Exit codes of the program. They are part of its interface; every --help lists them.
enum class ExitCode {
  done = 0,
  not_met = 1,    ///< a requirement is not met, or a design is only a compromise
  usage = 2,      ///< wrong options or arguments
  spec = 3,       ///< the spec is invalid
  mechanism = 4,  ///< the mechanism cannot do it: unreachable, singular, cannot be assembled
  system = 5,     ///< a file or system error
  signal = 128,   ///< plus the signal number: 130 after Ctrl-C
};

/// Invalid options or arguments.
class UsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A command line that cannot be parsed. The message refers the user to the usage.
class SyntaxUsageError : public UsageError {
 public:
  /// @param its_help the command that shows the usage
  explicit SyntaxUsageError(const std::string& reason, std::string its_help = "balance --help")
      : UsageError(reason), help(std::move(its_help)) {}
  std::string help;
};

/// The mechanism does not admit the requested conditions or design.
class MechanismFailure : public std::runtime_error {
 public:
  MechanismFailure(std::string its_status, const std::string& reason)
      : std::runtime_error(reason), status(std::move(its_status)) {}
  std::string status;
};

/// The mechanism cannot perform the requested motion.
class MotionFailure : public std::runtime_error {
 public:
  explicit MotionFailure(const MotionOutcome& result) : std::runtime_error(result.reason), outcome(result) {}
  /// Along a trajectory; where the spec says what moves, the message begins with its place.
  /// @param trajectory its name
  MotionFailure(const MotionOutcome& result, const Study& study, const std::string& trajectory);
  /// `spec.yaml:3:5: trajectories.run.free: …` or `error: …`
  std::string text() const;
  MotionOutcome outcome;
  SourceLocation place;  ///< without a line: none
};

}  // namespace balance::app
