#pragma once
/// A design's search under the user's eyes.

#include "design_options.hpp"
#include "failure.hpp"
#include "progress_line.hpp"
#include "signals.hpp"

#include "balance/base/computing_time.hpp"
#include "balance/write/pending_file.hpp"

#include <optional>
#include <string>
#include <utility>

namespace balance::app {

/// On a terminal it tells how far the search is; Ctrl-C ends it with what it has. @throws Cancelled if that is nothing
/// @param what is done, for the terminal
/// @param find does it, with the options that it is given
/// @param interrupted after how long Ctrl-C came [s]
template <class Find>
auto run_interruptible_search(const DesignCommandOptions& options, DesignStudyOptions wanted, const std::string& what,
                              std::optional<double>& interrupted, Find&& find) {
  ProgressLine line(options.quiet || options.spec.json);
  const InterruptGuard interrupt;
  const Stopwatch watch;
  wanted.on_progress = [&](const SearchProgress& progress) {
    line.draw_fraction(what, progress.seconds / progress.max_time);
    if (interrupt.was_interrupted() && !interrupted) interrupted = watch.seconds();
    return !interrupt.was_interrupted();
  };
  try {
    return std::forward<Find>(find)(wanted);
  } catch (const DeadlineExceeded&) {
    if (!interrupt.was_interrupted()) throw;
  } catch (const MechanismFailure&) {
    if (!interrupt.was_interrupted()) throw;
  }
  throw Cancelled(nothing_written_message);
}

}  // namespace balance::app
