#pragma once
/// How the program ends: part of its interface, listed in every --help.

namespace balance::app {

enum class ExitCode {
  done = 0,
  not_met = 1,    ///< a requirement is not met, or a design is only a compromise
  usage = 2,      ///< wrong options or arguments
  spec = 3,       ///< the spec is invalid
  mechanism = 4,  ///< the mechanism cannot do it: unreachable, singular, not assembled
  system = 5,     ///< a file or the system fails
  signal = 128,   ///< plus the signal's number: 130 after Ctrl-C
};

}  // namespace balance::app
